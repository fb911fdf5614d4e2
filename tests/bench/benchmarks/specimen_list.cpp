// `benchmark specimen` prints each property of both sensors under its own name, in its unit, measured as its name says.
// What measures them is replaced by functions that give round numbers, in which the arguments can be read.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/benchmarks/specimen.h"

using namespace tactbench::bench;

namespace {

// 0 for the paper's sensor, 1 for the harsh one; both as they are without options, sensor seed 1.
double kind_of_default(const SpecimenOptions& options) {
  SpecimenOptions expected;
  expected.kind = options.kind;
  CHECK(options.sensor_seed == 1);
  CHECK(options.rows == expected.rows);
  CHECK(options.columns == expected.columns);
  return options.kind == SpecimenKind::kHarsh ? 1.0 : 0.0;
}

SpecimenMeasures measures_that_tell() {
  SpecimenMeasures by;
  by.loop = [](const SpecimenOptions& options) {
    const double kind = kind_of_default(options);
    return LoopFigures{11.0 + kind, 21.0 + kind, 31.0 + kind};
  };
  by.cycles = [](const SpecimenOptions& options, int cycles) {
    return CycleFigures{100.0 * cycles + kind_of_default(options), 1000.0 * cycles + kind_of_default(options)};
  };
  by.creep = [](const SpecimenOptions& options, double level_psi, double from_s, double to_s) {
    return 1e9 * level_psi + 1e5 * from_s + to_s + kind_of_default(options);
  };
  by.walk = [](const SpecimenOptions& options, int hours) {
    return WalkFigures{100.0 * hours + kind_of_default(options), 1000.0 * hours + kind_of_default(options)};
  };
  by.crosstalk = [](const SpecimenOptions& options) {
    return CrosstalkFigures{0.25 + kind_of_default(options), 0.125 + kind_of_default(options), 7.0};
  };
  by.memory = [](const SpecimenOptions& options) {
    return MemoryFigures{41.0 + kind_of_default(options), 51.0 + kind_of_default(options)};
  };
  by.shape = [](const SpecimenOptions& options, int components) {
    return 100.0 * components + kind_of_default(options);
  };
  by.noise = [](const PlantOptions& options) {
    const double kind = kind_of_default(options.specimen);
    return NoiseFigures{61.0 + kind, 71.0 + kind, 2e-6 + 1e-6 * kind, -1.0 - kind, 81.0 + kind};
  };
  return by;
}

}  // namespace

TEST_CASE("benchmark specimen: every property of both sensors, with the arguments that its name says") {
  std::string text;
  for (const Figure& figure : benchmark_specimen(measures_that_tell()))
    text += fmt::format("{} {:.12g} {}\n", figure.name, figure.value, figure.unit);
  CHECK(text ==
        "specimen_paper_hysteresis_max 11 %FS\n"
        "specimen_paper_hysteresis_mean 21 %FS\n"
        "specimen_paper_full_scale 31 V\n"
        "specimen_paper_cycle_to_cycle_taxel 5000 %FS\n"
        "specimen_paper_cycle_to_cycle_mean_taxel 50000 %FS\n"
        "specimen_paper_creep_1_to_10_s 40000100010 %FS\n"
        "specimen_paper_creep_100_to_1000_s 40010001000 %FS\n"
        "specimen_paper_zero_walk_in_an_hour 2400 mV\n"
        "specimen_paper_gain_walk_in_an_hour 24000 %\n"
        "specimen_paper_crosstalk_beside 25 %\n"
        "specimen_paper_crosstalk_corner 12.5 %\n"
        "specimen_paper_minor_loops_not_congruent 41 %FS\n"
        "specimen_paper_minor_loop_not_closed 51 %FS\n"
        "specimen_paper_shape_beyond_five_components 500 %FS\n"
        "specimen_paper_white_noise 61 mV\n"
        "specimen_paper_kurtosis 71 1\n"
        "specimen_paper_beyond_five_sigma 2 ppm\n"
        "specimen_paper_slow_noise 81 %\n"
        "specimen_paper_noise_slope -1 1\n"
        "specimen_harsh_hysteresis_max 12 %FS\n"
        "specimen_harsh_hysteresis_mean 22 %FS\n"
        "specimen_harsh_full_scale 32 V\n"
        "specimen_harsh_cycle_to_cycle_taxel 5001 %FS\n"
        "specimen_harsh_cycle_to_cycle_mean_taxel 50001 %FS\n"
        "specimen_harsh_creep_1_to_10_s 40000100011 %FS\n"
        "specimen_harsh_creep_100_to_1000_s 40010001001 %FS\n"
        "specimen_harsh_zero_walk_in_an_hour 2401 mV\n"
        "specimen_harsh_gain_walk_in_an_hour 24001 %\n"
        "specimen_harsh_crosstalk_beside 125 %\n"
        "specimen_harsh_crosstalk_corner 112.5 %\n"
        "specimen_harsh_minor_loops_not_congruent 42 %FS\n"
        "specimen_harsh_minor_loop_not_closed 52 %FS\n"
        "specimen_harsh_shape_beyond_five_components 501 %FS\n"
        "specimen_harsh_white_noise 62 mV\n"
        "specimen_harsh_kurtosis 72 1\n"
        "specimen_harsh_beyond_five_sigma 3 ppm\n"
        "specimen_harsh_slow_noise 82 %\n"
        "specimen_harsh_noise_slope -2 1\n");
}
