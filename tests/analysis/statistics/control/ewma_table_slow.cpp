// The table behind ewma_probability(), drawn again.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/statistics/control/control_chart.h"
#include "analysis/statistics/numbers/moments.h"

using namespace tactbench::analysis;

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
