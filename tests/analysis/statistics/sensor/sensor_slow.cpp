// Drawn many times: outputs that changed since the fit (the table in analysis/README.md), well seated arrays, control
// charts without a shift, held-out runs.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/statistics/control/control_chart.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/statistics/sensor/seated.h"
#include "tests/analysis/support/fit_samples.h"

using tactbench::bench::SpecimenOptions;
using namespace synthetic;
using namespace tactbench;

TEST_CASE("drift: outputs 1 % lower to 0.5 % higher keep up and down within 1.2 % of full scale") {
  const Array array(ArrayOptions{});
  const Dataset first = run(array, RunOptions{});
  const SensorModel fits[] = {fit_array(first), fit_array(first, fit_by("elam", {.exact_outer = true}))};
  std::string table = "outputs, %; distance of the mean, % of full scale; with exact_outer\n";
  for (const double change : {0.0, -0.001, -0.002, -0.005, -0.01, 0.002, 0.005, 0.01}) {
    const Dataset data = run(array, {.seed = 2, .repeats = 1, .gain = 1.0 + change});
    double distance[2];
    for (int k = 0; k < 2; ++k) distance[k] = evaluate(data, fits[k]).comp_distance_of_mean;
    table += fmt::format("{:5.1f} {:6.2f} {:6.2f}\n", 100.0 * change, 100.0 * distance[0], 100.0 * distance[1]);
    if (change < 0.01) CHECK(distance[0] < 0.012);
  }
  WARN(table);
}

// The seating check raises no alarm on many arrays that are mounted well.

TEST_CASE("seating: 200 well seated arrays pass, when new and when mounted again a month later and warmer") {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const SeatingFrames first = seated(sensor(seed), seed);
    SpecimenOptions later = mounted_again(seed);
    later.temperature_c = 28.0;
    later.age_months = 1.0;
    later.effects.gain_drift_per_month = 0.01;
    later.effects.zero_drift_v_per_month = 0.01;
    for (const SeatingResult& result :
         {check_seating(16, 16, first, std::nullopt), check_seating(16, 16, seated(later, seed + 1000), first)}) {
      alarms += result.verdict == "pass" ? 0 : 1;
      if (!result.findings.empty()) UNSCOPED_INFO(seed << ": " << result.findings.front().text);
    }
  }
  CHECK(alarms == 0);
}

// The table behind ewma_probability(), drawn again.

TEST_CASE("EWMA chart: false alarms over 60 runs occur at the stated probability") {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  constexpr int kDrawnHistories = 40000;
  for (const int n : {8, 11, 20, 45, 400}) {
    std::vector<double> largest;
    for (int history = 0; history < kDrawnHistories; ++history) {
      std::vector<double> start_up(static_cast<std::size_t>(n));
      for (double& value : start_up) value = normal(random);
      EwmaControlChart chart = *EwmaControlChart::begin(start_up);
      double most = 0.0;
      for (int run = 0; run < kControlRuns; ++run) {
        chart.add(normal(random));
        most = std::max(most, std::abs(chart.state().statistic));
      }
      largest.push_back(ewma_probability(most, n));
    }
    for (const double probability : {0.3, 0.1, 0.05, 0.01, 0.002}) {
      const auto below =
          static_cast<double>(std::ranges::count_if(largest, [&](double own) { return own <= probability; }));
      INFO(n << " " << probability);
      // Four standard errors of the draws, and 2 % for the interpolation.
      const double error = std::sqrt(probability * (1.0 - probability) / kDrawnHistories);
      CHECK(below / kDrawnHistories == Approx(probability).margin(4.0 * error + 0.02 * probability));
    }
  }
}

// The purpose of the bench: a second run of the same sensor, compensated with the models of the first.

TEST_CASE("held-out runs: mean pressure of 256 taxels up and down agrees within 1 % of full scale") {
  struct Case {
    const char* name;
    unsigned sensor_seed;
    double top_fall, noise_v, play_share, gain, limit;
  };
  // Measured: 0.36, 0.40, 0.16, 0.62, 0.66, 0.27, 0.50 % (analysis/README.md); the bench's goal is 1.5 %.
  for (const Case& c : {Case{"as described", 1, 0.01, 0.0015, 0.015, 1.0, 0.0075},
                        Case{"another sensor", 9, 0.01, 0.0015, 0.015, 1.0, 0.0075},
                        Case{"flatter top, more noise", 1, 0.005, 0.004, 0.015, 1.0, 0.010},
                        Case{"twice the misfit", 1, 0.01, 0.0015, 0.030, 1.0, 0.010},
                        Case{"outputs 0.2 % higher", 1, 0.01, 0.0015, 0.015, 1.002, 0.010},
                        Case{"outputs 0.5 % lower", 1, 0.01, 0.0015, 0.015, 0.995, 0.010},
                        Case{"outputs 1 % lower", 1, 0.01, 0.0015, 0.015, 0.99, 0.010}}) {
    const Array array({.sensor_seed = c.sensor_seed,
                       .top_fall_low = c.top_fall,
                       .top_fall_high = 2.0 * c.top_fall,
                       .play_share = c.play_share});
    const SensorModel fit = fit_array(run(array, {.noise_v = c.noise_v}));
    for (const unsigned seed : {2U, 3U}) {
      const Dataset later = run(array, {.seed = seed, .noise_v = c.noise_v, .repeats = 1, .gain = c.gain});
      const Evaluation e = evaluate(later, fit);
      WARN(c.name << ", seed " << seed << ": raw " << 100 * e.raw_distance << " %, distance of the mean "
                  << 100 * e.comp_distance_of_mean << " %, mean taxel " << 100 * e.comp_distance << " (observable "
                  << 100 * e.comp_distance_observable << ") %, flat " << 100 * e.flat_share << " %, mean error "
                  << e.mean_error_psi << " psi");
      CHECK(e.comp_distance_of_mean < c.limit);
      CHECK(e.raw_distance > 0.08);
    }
  }
}
