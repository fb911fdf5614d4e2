// The foam: what it is meant to be, measured on outputs, on sensors that no constant was looked at on (those were 1 to
// 3).
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "bench/simulation/specimen.h"
#include "tests/bench/simulation/specimen_runs.h"
#include "tests/benchmarks/study/specimen.h"
#include "tests/benchmarks/study/specimen_walk.h"

namespace tactbench::bench::testing {
namespace {

Frame frame_of(const Specimen& specimen) {
  Frame volts(256);
  specimen.output(volts);
  return volts;
}

double farthest_taxel(const Frame& a, const Frame& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

// Farthest that the mean taxel's outputs of two cycles are apart, in volts.
double farthest_mean(const std::vector<Frame>& a, const std::vector<Frame>& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(mean(a[k]) - mean(b[k])));
  return most;
}

}  // namespace

TEST_CASE("foam: the output of every taxel rises during slow loading, new and conditioned, and stays on scale") {
  for (const std::uint64_t sensor : kNewSensors) {
    Specimen specimen(foam_sensor(sensor));
    double least_rise = 1.0, highest = 0.0;
    for (int cycle = 0; cycle < 4; ++cycle) {
      for (int psi = 0; psi <= 60; ++psi) {
        const Frame before = frame_of(specimen);
        specimen.advance(psi, 10.0);
        const Frame now = frame_of(specimen);
        // Below the pressure that lifts the membrane onto it nothing has to move.
        for (std::size_t i = 0; i < now.size() && psi > 1; ++i) least_rise = std::min(least_rise, now[i] - before[i]);
        highest = std::max(highest, *std::ranges::max_element(now));
      }
      specimen.advance(0.0, 60.0);
    }
    CHECK(least_rise > 0.0);
    CHECK(highest < 5.0);
  }
}

TEST_CASE("foam: hysteresis is 10 to 25 % FS, different for each taxel, and full scale is about that of the films") {
  for (const std::uint64_t sensor : kNewSensors) {
    const LoopFigures loop = measure_loop(foam_sensor(sensor));
    CHECK(loop.max_percent_fs > 10.0);
    CHECK(loop.max_percent_fs < 25.0);
    CHECK(loop.mean_percent_fs > 4.0);
    CHECK(loop.full_scale_v == Approx(3.2).margin(0.4));
    // No five shapes describe all taxels: their constants are their own.
    CHECK(measure_shape_percent_fs(foam_sensor(sensor), 5) > 0.01);
  }
}

TEST_CASE("foam: creep is 0.2 to 4 % FS per decade up to 1000 s, falls after unloading, and ends within hours") {
  for (const std::uint64_t sensor : kNewSensors) {
    for (const double level : {10.0, 40.0})
      for (const double from_s : {1.0, 10.0, 100.0}) {
        const double creep = measure_creep_percent_fs(foam_sensor(sensor), level, from_s, 10.0 * from_s);
        CHECK(creep > 0.2);
        CHECK(creep < 4.0);
      }
    CHECK(std::abs(measure_creep_percent_fs(foam_sensor(sensor), 40.0, 1e4, 2e4)) < 0.2);
    SpecimenWalk walk(foam_sensor(sensor));
    walk.condition();
    walk.jump(60.0);
    walk.hold(600.0);
    walk.jump(4.0);
    const double early = mean(walk.output());
    walk.hold(100.0);
    CHECK(mean(walk.output()) < early - 0.01);
  }
}

TEST_CASE("foam: friction leaves a remanence that no rest removes, smaller than the part that relaxes") {
  for (const std::uint64_t sensor : kNewSensors) {
    const double early = measure_remanence_percent_fs(foam_sensor(sensor), 10.0);
    const double hour = measure_remanence_percent_fs(foam_sensor(sensor), 3600.0);
    const double days = measure_remanence_percent_fs(foam_sensor(sensor), 3e5);
    CHECK(early < 8.0);
    CHECK(hour < 0.5 * early);
    CHECK(days > 0.2);
    CHECK(days == Approx(hour).margin(0.5));
  }
}

TEST_CASE("foam: a load reached from above and from below does not give the same state") {
  const auto at_20 = [](double from) {
    SpecimenWalk walk(foam_sensor(kNewSensors[0]));
    walk.condition();
    walk.jump(from);
    walk.hold(60.0);
    walk.jump(20.0);
    walk.hold(36000.0);
    return mean(walk.output());
  };
  CHECK(at_20(60.0) - at_20(0.0) > 0.03);
}

TEST_CASE("foam: minor loops between equal ends are not congruent") {
  const auto height = [](std::uint64_t sensor, double entry, double low, double high) {
    SpecimenWalk walk(foam_sensor(sensor));
    walk.condition_at_once();
    walk.at_once({entry, low, high, low});
    const double bottom = mean(walk.output());
    walk.at_once({high});
    return mean(walk.output()) - bottom;
  };
  for (const std::uint64_t sensor : kNewSensors)
    for (const double low : {10.0, 20.0, 30.0})
      CHECK(height(sensor, 0.0, low, low + 10.0) - height(sensor, 60.0, low, low + 10.0) > 0.008);
}

TEST_CASE("foam: a quick loop differs from a slow one") {
  SpecimenWalk quick(foam_sensor(kNewSensors[0])), usual(foam_sensor(kNewSensors[0]));
  for (SpecimenWalk* walk : {&quick, &usual}) walk->condition();
  quick.hold(3600.0);
  usual.hold(3600.0);
  quick.at_once({30.0});
  usual.jump(30.0);
  CHECK(mean(usual.output()) - mean(quick.output()) > 0.03);
}

TEST_CASE("foam: the first cycles soften it, less each time, and a week of rest restores it") {
  SpecimenWalk walk(foam_sensor(kNewSensors[0]));
  std::vector<std::vector<Frame>> cycles;
  for (int cycle = 0; cycle < 5; ++cycle) {
    cycles.push_back(walk.loop());
    walk.hold(3600.0);  // so that only softening is left
  }
  const double first = farthest_mean(cycles[0], cycles[1]), second = farthest_mean(cycles[1], cycles[2]);
  CHECK(first > 0.05);
  CHECK(second < 0.5 * first);
  CHECK(farthest_mean(cycles[3], cycles[4]) < second);
  walk.hold(7.0 * 86400.0);
  CHECK(farthest_mean(cycles[0], walk.loop()) < 0.5 * first);
}

TEST_CASE("foam: one long step gives the same state as many short ones") {
  for (const std::uint64_t sensor : kNewSensors) {
    SpecimenOptions options = foam_sensor(sensor);
    options.effects.lift_off_psi = 0.0;  // else the ways near 0 psi differ
    Specimen cut(options), whole(options);
    const auto both = [&](double from, double to, double seconds, int pieces) {
      for (int k = 1; k <= pieces; ++k) cut.advance(from + (to - from) * k / pieces, seconds / pieces);
      whole.advance(to, seconds);
      CHECK(farthest_taxel(frame_of(cut), frame_of(whole)) < 0.002);
    };
    both(0.0, 60.0, 2.0, 600);
    both(60.0, 60.0, 600.0, 6000);
    both(60.0, 12.0, 30.0, 600);
    both(12.0, 12.0, 100.0, 2000);
    both(12.0, 33.0, 1e-6, 200);
    both(33.0, 0.0, 5.0, 500);
    both(0.0, 0.0, 3000.0, 6000);
  }
}

TEST_CASE("foam: at extreme loads outputs stay finite and in range") {
  Specimen specimen(foam_sensor(kNewSensors[0]));
  Frame contact(256, 0.0);
  contact[40] = 200.0;
  for (int k = 0; k < 50; ++k) {
    specimen.advance(k % 2 == 0 ? 120.0 : 0.0, k % 3 == 0 ? 1e-9 : 1e6, contact);
    for (const double volts : frame_of(specimen)) REQUIRE((volts >= 0.0 && volts <= 5.0));
  }
}

TEST_CASE("foam: the skin couples a few percent into the neighbours of a single pressed taxel, and no farther") {
  for (const std::uint64_t sensor : kNewSensors) {
    const CrosstalkFigures skin = measure_crosstalk(foam_sensor(sensor));
    CHECK(skin.beside > 0.01);
    CHECK(skin.beside < 0.15);
    CHECK(skin.corner < skin.beside);
    CHECK(skin.two_away == Approx(0.0).margin(1e-12));
  }
}

TEST_CASE("foam: temperature, re-mounting and age change the output") {
  const auto read = [](const SpecimenOptions& options) {
    Specimen specimen(options);
    specimen.advance(30.0, 1.0);
    return frame_of(specimen);
  };
  const SpecimenOptions usual = foam_sensor(kNewSensors[0]);
  SpecimenOptions warm = usual, mounted = usual, aged = usual;
  warm.temperature_c = 33.0;
  warm.effects.temperature_coefficient = 0.0;  // relaxation alone
  mounted.mount_seed = 3;
  mounted.effects.remount_variation = 0.05;
  aged.age_months = 2.0;
  aged.effects.zero_drift_v_per_month = 0.02;
  CHECK(mean(read(warm)) > mean(read(usual)) + 0.005);
  CHECK(farthest_taxel(read(mounted), read(usual)) > 0.02);
  CHECK(mean(read(aged)) == Approx(mean(read(usual)) + 0.04).margin(1e-9));
}

// The harsh specimen: each property by its figure, measured on outputs, on sensors and runs that no constant was set
// on.

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

TEST_CASE("harsh specimen: hysteresis and full scale are about those of the paper sensor") {
  for (const std::uint64_t sensor : kNewSensors) {
    const LoopFigures loop = measure_loop(harsh_sensor(sensor));
    CHECK(loop.max_percent_fs == Approx(25.0).margin(5.0));
    CHECK(loop.mean_percent_fs == Approx(10.0).margin(3.0));
    CHECK(loop.full_scale_v == Approx(3.4).margin(0.25));
  }
}

TEST_CASE("harsh specimen: friction varies by 0.6 % FS over 50 cycles, about half of it common to all taxels") {
  for (const std::uint64_t sensor : kNewSensors) {
    const CycleFigures harsh = measure_cycles(harsh_sensor(sensor), 50);
    CHECK(harsh.taxel_percent_fs == Approx(0.6).margin(0.15));
    CHECK(harsh.mean_taxel_percent_fs == Approx(0.38).margin(0.2));
  }
  CHECK(measure_cycles(paper_sensor(52163), 50).taxel_percent_fs < 0.02);
}

TEST_CASE("harsh specimen: creep is 5 % FS per decade from 1 s to 1000 s") {
  for (const std::uint64_t sensor : kNewSensors) {
    for (const double from_s : {1.0, 10.0, 100.0}) {
      const double creep = measure_creep_percent_fs(harsh_sensor(sensor), 40.0, from_s, 10.0 * from_s);
      CHECK(creep == Approx(5.0).margin(0.8));
    }
  }
  CHECK(measure_creep_percent_fs(paper_sensor(52163), 40.0, 1.0, 10.0) < 2.0);
}

TEST_CASE("harsh specimen: zero and gain drift as a random walk, with the square root of time") {
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

TEST_CASE("harsh specimen: a single pressed taxel affects its neighbours, and none beyond") {
  for (const std::uint64_t sensor : kNewSensors) {
    const CrosstalkFigures harsh = measure_crosstalk(harsh_sensor(sensor));
    CHECK(harsh.beside == Approx(0.022).margin(0.004));
    CHECK(harsh.corner == Approx(0.0055).margin(0.002));
    CHECK(harsh.two_away == Approx(0.0).margin(1e-12));
  }
  CHECK(measure_crosstalk(paper_sensor(52163)).beside == Approx(0.0).margin(1e-12));
}

TEST_CASE("harsh specimen: is not a Preisach model behind a divider, minor loops are neither congruent nor closed") {
  for (const std::uint64_t sensor : kNewSensors) {
    const MemoryFigures harsh = measure_memory(harsh_sensor(sensor)), paper = measure_memory(paper_sensor(sensor));
    CHECK(harsh.congruency_percent_fs > 1.0);
    CHECK(harsh.closure_percent_fs > 0.4);
    CHECK(paper.closure_percent_fs < 0.01);
  }
}

}  // namespace tactbench::bench::testing
