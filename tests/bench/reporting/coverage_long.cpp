// By command: the report's U against the truth, the plant's pressure, on sensors and histories that nothing was chosen
// on, by kind of history. What U is stated for has to hold.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/identify/sensor_model.h"
#include "tests/benchmarks/study/coverage.h"
#include "tests/benchmarks/study/simulated_run.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// `stated`: sensors for which U of full sweeps, reversals and held pressures has to be stated, else a report that is
// valid for nothing would pass.
void check_coverage(bench::SpecimenKind specimen, std::uint64_t seed, int stated) {
  const TemporaryFolder folder;
  bench::CoverageOptions options;
  options.seed = seed;
  options.specimens = {specimen};
  options.sensors = 6;
  const bench::CoverageOfSpecimen found = bench::study_coverage(options, folder.path()).front();
  UNSCOPED_INFO(bench::markdown_of({found}));
  for (const bench::CoverageOfKind& kind : found.kinds) {
    CAPTURE(analysis::name_of(kind.kind));
    if (kind.kind != analysis::UseCondition::kSmallReversals) CHECK(kind.stated >= stated);
    if (kind.stated == 0) continue;
    CHECK(kind.percent >= 92.0);
    CHECK(kind.percent <= 98.5);
    CHECK(kind.outside <= 1);
    CHECK(kind.median_u_psi <= 1.3 * kind.half_width_psi);
  }
  for (const bench::CoveredSensor& sensor : found.sensors) CHECK(sensor.minutes <= 25.0);
}

}  // namespace

TEST_CASE("U covers 92 to 98.5 % of readings of the paper specimen, for each kind of history that it is stated for") {
  check_coverage(bench::SpecimenKind::kPaper, 4100, 5);
}

TEST_CASE("U covers 92 to 98.5 % of readings of the harsh specimen, for each kind of history that it is stated for") {
  check_coverage(bench::SpecimenKind::kHarsh, 4200, 4);
}

// The uncertainty of ELAM's frames against the truth, the plant's pressure, on random reversals of sensors of the
// paper's specimen that nothing was chosen on.

namespace {

struct Held {
  double within = 0.0, samples = 0.0;
  [[nodiscard]] double percent() const { return 100.0 * within / samples; }
};

// Frames from rest, in volts; samples that are valid.
Held held_of(const analysis::SensorModel& model, const bench::KnownRun& run) {
  analysis::FrameCompensator compensator = analysis::frames_of(model);
  compensator.start(analysis::Start::kAtRest);
  const std::size_t width = compensator.taxels();
  std::vector<float> volts(width), pressure(width), uncertainty(width);
  std::vector<std::uint16_t> status(width);
  Held held;
  std::size_t frame = 0;
  for (const analysis::SequenceData& sequence : run.data.sequences)
    for (const analysis::Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i, ++frame) {
        for (std::size_t t = 0; t < width; ++t) volts[t] = static_cast<float>(repeat.volts[i * width + t]);
        compensator.frame(volts, 0.0, {pressure, uncertainty, status});
        for (std::size_t t = 0; t < width; ++t) {
          if ((status[t] & analysis::kTaxelValid) == 0) continue;
          const double error = std::abs(static_cast<double>(pressure[t]) - run.chamber_psi[frame]);
          held.samples += 1.0;
          held.within += error <= 2.0 * static_cast<double>(uncertainty[t]) ? 1.0 : 0.0;
        }
      }
  return held;
}

}  // namespace

TEST_CASE("ELAM frames: 2 u covers 90 to 98 % of random reversals, noise alone covers few") {
  const TemporaryFolder folder;
  Held with, alone;
  for (const unsigned sensor_seed : {91U, 92U}) {
    db::RunStore store = db::RunStore::open(folder.path(std::to_string(sensor_seed) + ".db"), db::Durability::kNormal);
    const bench::SimulatedSensor sensor{.seed = sensor_seed};
    const bench::KnownRun fitted = bench::simulate_run({{"descending", "ascending"}, {}}, sensor, 1, store);
    const bench::KnownRun other = bench::simulate_run({{"random-reversal"}, {"recipe.seed=5"}}, sensor, 2, store);
    analysis::SensorModel model = analysis::fit_array(fitted.data);
    const Held own = held_of(model, other);
    for (analysis::ModelTaxel& taxel : model.taxels) taxel.residual_psi = 0.0;
    const Held noise = held_of(model, other);
    INFO("sensor " << sensor_seed << ": " << own.percent() << " %, noise alone " << noise.percent() << " % of "
                   << own.samples);
    CHECK(own.percent() > 88.0);  // one sensor
    CHECK(noise.percent() < 50.0);
    with.within += own.within, with.samples += own.samples;
    alone.within += noise.within, alone.samples += noise.samples;
  }
  INFO("both sensors: " << with.percent() << " %, noise alone " << alone.percent() << " %");
  CHECK(with.samples > 100'000.0);
  CHECK(with.percent() > 90.0);
  CHECK(with.percent() < 98.0);
}
