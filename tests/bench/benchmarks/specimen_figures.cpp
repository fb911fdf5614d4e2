// The figures about a simulated sensor (bench/benchmarks/specimen.h) on small arrays: what another implementation of
// the film and of each definition gives for the same seeds, in Python. A deliberate change of the film changes them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/benchmarks/specimen.h"
#include "bench/benchmarks/specimen_walk.h"

using namespace tactbench::bench;

namespace {

Approx figure_of(double value) { return Approx(value).epsilon(1e-8).margin(1e-9); }

SpecimenOptions small(SpecimenKind kind, int rows, int columns) {
  SpecimenOptions options;
  options.kind = kind;
  options.sensor_seed = 52163;
  options.rows = rows;
  options.columns = columns;
  return options;
}

constexpr SpecimenKind kPaper = SpecimenKind::kPaper, kHarsh = SpecimenKind::kHarsh;

}  // namespace

TEST_CASE("specimen figures: external loop, cycle to cycle and creep of six taxels") {
  const LoopFigures paper = measure_loop(small(kPaper, 2, 3)), harsh = measure_loop(small(kHarsh, 2, 3));
  CHECK(paper.max_percent_fs == figure_of(24.30754756435419));
  CHECK(paper.mean_percent_fs == figure_of(9.11977198297997));
  CHECK(paper.full_scale_v == figure_of(3.470855193254944));
  CHECK(harsh.max_percent_fs == figure_of(28.200175147268624));
  CHECK(harsh.mean_percent_fs == figure_of(11.21806876564197));
  CHECK(harsh.full_scale_v == figure_of(3.457013807647129));
  const CycleFigures calm = measure_cycles(small(kPaper, 2, 3), 4), rough = measure_cycles(small(kHarsh, 2, 3), 4);
  CHECK(calm.taxel_percent_fs == figure_of(0.017098584284907764));
  CHECK(calm.mean_taxel_percent_fs == figure_of(0.01683346920791088));
  CHECK(rough.taxel_percent_fs == figure_of(0.5680110153050532));
  CHECK(rough.mean_taxel_percent_fs == figure_of(0.49182114026549945));
  CHECK(measure_creep_percent_fs(small(kPaper, 2, 3), 40.0, 2.0, 20.0) == figure_of(1.299113279826502));
  CHECK(measure_creep_percent_fs(small(kHarsh, 2, 3), 40.0, 2.0, 20.0) == figure_of(5.706759684199992));
}

TEST_CASE("specimen figures: walks of three hours, which the paper's sensor has not") {
  const WalkFigures paper = measure_walk(small(kPaper, 2, 3), 3), harsh = measure_walk(small(kHarsh, 2, 3), 3);
  CHECK(paper.zero_mv == figure_of(0.0));
  CHECK(paper.gain_percent == figure_of(0.0));
  CHECK(harsh.zero_mv == figure_of(2.8809578442003643));
  CHECK(harsh.gain_percent == figure_of(0.2639424402663327));
}

TEST_CASE("specimen figures: crosstalk of row and column beside that of a film, two taxels pressed") {
  const auto crosstalk = [](SpecimenKind kind) {
    SpecimenOptions options = small(kind, 8, 5);
    options.effects.row_crosstalk = 0.04;
    options.effects.column_crosstalk = 0.02;
    return measure_crosstalk(options);
  };
  // The other four of a row share 4 %, the other seven of a column 2 %.
  const CrosstalkFigures paper = crosstalk(kPaper), harsh = crosstalk(kHarsh);
  CHECK(paper.beside == figure_of((0.04 / 4 + 0.02 / 7) / 2));
  CHECK(paper.corner == figure_of(0.0));
  CHECK(paper.two_away == figure_of((0.04 / 4 + 0.02 / 7) / 2));
  CHECK(harsh.beside == figure_of(0.02817295479976667));
  CHECK(harsh.corner == figure_of(0.006403565362146494));
  CHECK(harsh.two_away == figure_of(0.006794606440518922));
  const CrosstalkFigures none = measure_crosstalk(small(kPaper, 4, 4));  // too small: nothing is pressed
  CHECK((none.beside == 0.0 && none.corner == 0.0 && none.two_away == 0.0));
}

TEST_CASE("specimen figures: minor loops that are not congruent and do not close, means of eight runs") {
  const MemoryFigures paper = measure_memory(small(kPaper, 1, 2)), harsh = measure_memory(small(kHarsh, 1, 2));
  CHECK(paper.congruency_percent_fs == figure_of(0.9602630247243409));
  CHECK(paper.closure_percent_fs == Approx(5.59582324695581e-06).epsilon(1e-4));
  CHECK(harsh.congruency_percent_fs == figure_of(1.4863294659873079));
  CHECK(harsh.closure_percent_fs == figure_of(0.632265660662326));
}

TEST_CASE("specimen figures: what common shapes leave of the loops of twelve taxels") {
  CHECK(measure_shape_percent_fs(small(kPaper, 3, 4), 2) == figure_of(2.0382712618207486));
  CHECK(measure_shape_percent_fs(small(kPaper, 3, 4), 1) == figure_of(3.7014727922088286));
  CHECK(measure_shape_percent_fs(small(kHarsh, 3, 4), 2) == figure_of(2.179611933021183));
  CHECK(measure_shape_percent_fs(small(kPaper, 3, 4), 100) == 0.0);
}

TEST_CASE("specimen figures: noise of single samples and slow noise, from scans against the truth") {
  // White noise of 1.5 mV, a sum of four uniforms (kurtosis 2.7) that ends at 3.46 standard deviations; converter steps
  // of 76 uV.
  PlantOptions plant;
  plant.specimen = small(kPaper, 8, 8);
  plant.scanner.relay_time_constant_s = 1e-4;  // nothing is left of the row before
  const NoiseFigures noise = measure_noise(plant);
  CHECK(noise.white_mv == Approx(1.5).epsilon(0.02));
  CHECK(noise.kurtosis == Approx(2.7).margin(0.05));
  CHECK(noise.beyond_five == 0.0);
  // White noise over 32 s means, of some 2.9 V; its spectrum is level.
  CHECK(noise.slope == Approx(0.0).margin(0.15));
  CHECK(noise.slow_percent_of_output == Approx(100.0 * 0.0015 / std::sqrt(32.0) / 2.9).epsilon(0.2));
  plant.scanner.noise_v = 0.003;
  CHECK(measure_noise(plant).white_mv == Approx(3.0).epsilon(0.02));
}

TEST_CASE("specimen figures: noise of both sensors as it was recorded, the harsh one's falls with frequency") {
  const auto check_noise = [](SpecimenKind kind, const NoiseFigures& recorded) {
    PlantOptions plant;
    plant.specimen = small(kind, 8, 8);
    plant.scanner.relay_time_constant_s = 1e-4;
    const NoiseFigures noise = measure_noise(plant);
    CHECK(noise.white_mv == Approx(recorded.white_mv).epsilon(1e-5));
    CHECK(noise.kurtosis == Approx(recorded.kurtosis).epsilon(1e-5));
    CHECK(noise.beyond_five == Approx(recorded.beyond_five).epsilon(1e-4));
    CHECK(noise.slope == Approx(recorded.slope).margin(1e-4));
    CHECK(noise.slow_percent_of_output == Approx(recorded.slow_percent_of_output).epsilon(1e-3));
  };
  check_noise(kPaper, {1.499372, 2.700108, 0.0, -0.011437, 0.008918});
  check_noise(kHarsh, {1.502834, 6.784789, 0.00136719, -1.062174, 0.084196});
}

TEST_CASE("specimen figures: one cycle alone has no other to differ from") {
  const CycleFigures none = measure_cycles(small(kHarsh, 1, 2), 1);
  CHECK(none.taxel_percent_fs == 0.0);
  CHECK(none.mean_taxel_percent_fs == 0.0);
}

TEST_CASE("a walk along a specimen goes and holds as its header says") {
  SpecimenWalk walk(small(kPaper, 1, 1));
  const auto frames = walk.loop();
  REQUIRE(frames.size() == 61);
  CHECK(frames.front().size() == 1);
  // The same by hand: 2 psi in four pieces of 0.1 s, then four of 0.5 s.
  Specimen specimen(small(kPaper, 1, 1));
  std::vector<double> volts(1);
  for (int level = 1; level <= 60; ++level) {
    const double from = level <= 30 ? 2.0 * (level - 1) : 2.0 * (61 - level), step = level <= 30 ? 0.5 : -0.5;
    for (int piece = 1; piece <= 4; ++piece) specimen.advance(from + step * piece, 0.1);
    for (int piece = 0; piece < 4; ++piece) specimen.advance(from + 4.0 * step, 0.5);
    specimen.output(volts);
    INFO("level " << level);
    CHECK(frames[static_cast<std::size_t>(level)][0] == Approx(volts[0]).epsilon(1e-12));
  }
}

TEST_CASE("specimen figures: of crosstalk each third taxel is pressed that has two others on each side, as recorded") {
  const auto check_crosstalk = [](int rows, int columns, const CrosstalkFigures& recorded) {
    INFO(rows << " x " << columns);
    const CrosstalkFigures own = measure_crosstalk(small(kHarsh, rows, columns));
    CHECK(own.beside == figure_of(recorded.beside));
    CHECK(own.corner == figure_of(recorded.corner));
    CHECK(own.two_away == figure_of(recorded.two_away));
  };
  check_crosstalk(5, 5, {0.0195654858018, 0.00598163293911, 0});
  check_crosstalk(7, 8, {0.0207769534516, 0.00630830902722, 0});
  check_crosstalk(8, 7, {0.0219707606674, 0.00620775041353, 0});
}

TEST_CASE("a walk presses an object on the taxels in four pieces, and holds in pieces that grow to ten minutes") {
  SpecimenOptions options = small(kHarsh, 1, 2);
  SpecimenWalk walk(options);
  Specimen specimen(options);
  std::vector<double> volts(2);
  const auto check_equal = [&] {
    specimen.output(volts);
    const std::vector<double> own = walk.output();
    for (std::size_t i = 0; i < 2; ++i) CHECK(own[i] == Approx(volts[i]).epsilon(1e-12));
  };
  walk.press(std::vector<double>{40.0, 12.0});
  for (const double share : {0.25, 0.5, 0.75, 1.0})
    specimen.advance(0.0, 0.1, std::vector<double>{40.0 * share, 12.0 * share});
  check_equal();
  walk.jump(1.0);  // four pieces of 0.25 psi at 40 psi/s
  for (const double psi : {0.25, 0.5, 0.75, 1.0}) specimen.advance(psi, 0.25 / 40.0);
  check_equal();
  walk.hold(3000.0);
  double left = 3000.0;
  for (double piece = 0.05; left > 0.0; piece = std::min(600.0, 2.0 * piece)) {
    specimen.advance(1.0, std::min(piece, left));
    left -= piece;
  }
  check_equal();
  walk.at_once({0.5, 0.75});
  for (const double psi : {0.75, 0.5, 0.75}) specimen.advance(psi, 1e-9);
  check_equal();
}
