// The harsh specimen: each property by its figure, measured on outputs, on sensors and runs that no constant was set
// on.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bench/simulation/specimen.h"
#include "tests/bench/simulation/harsh_sensor.h"
#include "tests/benchmarks/study/specimen.h"

namespace tactbench::bench::testing {
TEST_CASE("harsh specimen: no output falls while the load rises, or rises while it falls, by more than creep") {
  for (const std::uint64_t sensor : kNewSensors) {
    Specimen specimen(harsh_sensor(sensor));
    std::vector<double> before(256), now(256);
    double worst = 0.0, pressure = 0.0;
    for (const double point : {60.0, 0.0, 60.0, 0.0, 60.0, 10.0, 30.0, 20.0, 50.0, 5.0, 15.0, 12.0, 60.0, 40.0, 45.0}) {
      const double step = point > pressure ? 0.25 : -0.25;
      specimen.output(before);
      while (std::abs(point - pressure) > 1e-9) {
        pressure += step;
        specimen.advance(pressure, 1e-9);
        specimen.output(now);
        for (std::size_t i = 0; i < now.size(); ++i)
          worst = std::max(worst, step > 0.0 ? before[i] - now[i] : now[i] - before[i]);
        before = now;
      }
    }
    CHECK(worst < 0.003);
  }
}

TEST_CASE("harsh specimen: hysteresis and full scale are about those of the paper's sensor") {
  for (const std::uint64_t sensor : kNewSensors) {
    const LoopFigures loop = measure_loop(harsh_sensor(sensor));
    CHECK(loop.max_percent_fs == Approx(25.0).margin(5.0));
    CHECK(loop.mean_percent_fs == Approx(10.0).margin(3.0));
    CHECK(loop.full_scale_v == Approx(3.4).margin(0.25));
  }
}

TEST_CASE("harsh specimen: friction varies from cycle to cycle by 0.6 % FS over 50 cycles, half of it in all taxels") {
  for (const std::uint64_t sensor : kNewSensors) {
    const CycleFigures harsh = measure_cycles(harsh_sensor(sensor), 50);
    CHECK(harsh.taxel_percent_fs == Approx(0.6).margin(0.15));
    CHECK(harsh.mean_taxel_percent_fs == Approx(0.38).margin(0.2));
  }
  CHECK(measure_cycles(paper_sensor(52163), 50).taxel_percent_fs < 0.02);
}

TEST_CASE("harsh specimen: 5 % FS of creep in each decade of time from 1 s to 1000 s") {
  for (const std::uint64_t sensor : kNewSensors) {
    for (const double from_s : {1.0, 10.0, 100.0}) {
      const double creep = measure_creep_percent_fs(harsh_sensor(sensor), 40.0, from_s, 10.0 * from_s);
      CHECK(creep == Approx(5.0).margin(0.8));
    }
  }
  CHECK(measure_creep_percent_fs(paper_sensor(52163), 40.0, 1.0, 10.0) < 2.0);
}

TEST_CASE("harsh specimen: zero and gain walk, by the square root of time") {
  const WalkFigures harsh = measure_walk(harsh_sensor(52163), 48);
  CHECK(harsh.zero_mv == Approx(3.5).margin(1.0));
  CHECK(harsh.gain_percent == Approx(0.3).margin(0.1));
  const WalkFigures paper = measure_walk(paper_sensor(52163), 8);
  CHECK(paper.zero_mv == Approx(0.0).margin(1e-6));
  CHECK(paper.gain_percent == 0.0);
  // Unloaded, nothing else moves: over 16 hours four times as far as over one.
  double one = 0.0, sixteen = 0.0;
  for (std::uint64_t run = 1; run <= 30; ++run) {
    SpecimenOptions options = harsh_sensor(52163, run);
    options.rows = options.columns = 4;
    Specimen specimen(options);
    std::vector<double> start(16), first(16), last(16);
    specimen.output(start);
    for (int k = 0; k < 6; ++k) specimen.advance(0.0, 600.0);
    specimen.output(first);
    for (int k = 0; k < 90; ++k) specimen.advance(0.0, 600.0);
    specimen.output(last);
    for (std::size_t i = 0; i < 16; ++i) {
      one += std::pow(first[i] - start[i], 2);
      sixteen += std::pow(last[i] - start[i], 2);
    }
  }
  CHECK(std::sqrt(sixteen / one) == Approx(4.0).margin(1.2));
}

TEST_CASE("harsh specimen: white noise has heavy tails, slow noise falls as 1/f") {
  PlantOptions paper;
  paper.specimen = paper_sensor(52163);
  paper.seed = 1234;
  const NoiseFigures harsh = measure_noise(harsh_plant(52163, 1234)), kind = measure_noise(paper);
  CHECK(harsh.white_mv == Approx(1.5).epsilon(0.05));
  CHECK(harsh.kurtosis > 5.0);
  CHECK(harsh.beyond_five > 3e-4);
  CHECK(harsh.beyond_five < 3e-3);
  CHECK(harsh.slope == Approx(-1.0).margin(0.25));
  CHECK(kind.kurtosis == Approx(2.7).margin(0.05));  // the sum of four uniforms: 3 - 1.2 / 4
  CHECK(kind.beyond_five == 0.0);
  CHECK(kind.slope == Approx(0.0).margin(0.15));
  CHECK(harsh.slow_percent_of_output > 3.0 * kind.slow_percent_of_output);
}

TEST_CASE("harsh specimen: a taxel pressed alone is seen by its neighbours, and not beyond") {
  for (const std::uint64_t sensor : kNewSensors) {
    const CrosstalkFigures harsh = measure_crosstalk(harsh_sensor(sensor));
    CHECK(harsh.beside == Approx(0.022).margin(0.004));
    CHECK(harsh.corner == Approx(0.0055).margin(0.002));
    CHECK(harsh.two_away == Approx(0.0).margin(1e-12));
  }
  CHECK(measure_crosstalk(paper_sensor(52163)).beside == Approx(0.0).margin(1e-12));
}

TEST_CASE("harsh specimen: no Preisach model behind a divider: minor loops are neither congruent nor closed") {
  for (const std::uint64_t sensor : kNewSensors) {
    const MemoryFigures harsh = measure_memory(harsh_sensor(sensor)), paper = measure_memory(paper_sensor(sensor));
    CHECK(harsh.congruency_percent_fs > 1.0);
    CHECK(harsh.closure_percent_fs > 0.4);
    CHECK(paper.closure_percent_fs < 0.01);
  }
}

}  // namespace tactbench::bench::testing
