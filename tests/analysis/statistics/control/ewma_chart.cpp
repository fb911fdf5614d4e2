// The chart of one figure against values computed by hand, and its promised rates of false alarms and of shifts found.
#include "analysis/statistics/control/ewma_chart.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/statistics/control/control_band.h"
#include "analysis/statistics/control/false_discovery.h"
#include "analysis/statistics/control/figure_chart.h"
#include "analysis/statistics/numbers/student.h"

using namespace tactbench::analysis;

namespace {

// Mean 10, sum of squares 7, so that the deviation is 1.
const std::array kStartUp = {9.0, 11.0, 9.0, 11.0, 10.0 - std::sqrt(1.5), 10.0 + std::sqrt(1.5), 10.0, 10.0};

}  // namespace

TEST_CASE("EWMA chart: the first three runs by hand") {
  std::optional<EwmaChart> chart = EwmaChart::begin(kStartUp);
  REQUIRE(chart);
  CHECK(chart->state().mean == Approx(10.0));
  CHECK(chart->state().deviation == Approx(1.0));
  CHECK(chart->probability() == 1.0);
  chart->add(12.0);  // z = 0.2 x 2; variance 0.2^2 (1 + 1/8) = 0.045
  CHECK(chart->state().ewma == Approx(0.4));
  CHECK(chart->state().statistic == Approx(0.4 / std::sqrt(0.045)));
  chart->add(13.0);  // z = 0.2 x 3 + 0.8 x 0.4 = 0.92; variance 0.2^2 (1 + 0.64) + 0.36^2 / 8 = 0.0818
  CHECK(chart->state().ewma == Approx(0.92));
  CHECK(chart->state().statistic == Approx(0.92 / std::sqrt(0.0818)));
  chart->add(10.0);  // z = 0.736; variance 0.04 (1 + 0.64 + 0.4096) + 0.488^2 / 8 = 0.111752
  CHECK(chart->state().statistic == Approx(0.736 / std::sqrt(0.111752)));
  CHECK(chart->state().later == 3);
}

TEST_CASE("EWMA chart: a gross value stays out of the average, and what cannot be charted") {
  std::optional<EwmaChart> chart = EwmaChart::begin(kStartUp);
  const double limit = student_quantile(1.0 - 0.5e-5, 7.0) * std::sqrt(1.125);
  chart->add(10.0 - 1.001 * limit);
  CHECK((chart->state().ewma == 0.0 && chart->state().later == 0 && chart->probability() == 1.0));
  chart->add(10.0 - 0.999 * limit);
  CHECK(chart->state().ewma == Approx(-0.2 * 0.999 * limit));
  CHECK_FALSE(EwmaChart::begin(std::span(kStartUp).first(7)));
  CHECK_FALSE(EwmaChart::begin(std::vector<double>(8, 4.0)));
}

TEST_CASE("EWMA chart: the probability in sixty runs lies between that of one and sixty times it") {
  for (const int n : {8, 9, 25, 60, 500})
    for (double one = 0.9; one > 1e-12; one *= 0.37) {
      const double t = student_quantile(1.0 - one / 2.0, n - 1.0), sixty = chart_probability(t, n);
      INFO(n << " " << one);
      CHECK((sixty >= one && sixty <= 60.0 * one && sixty <= 1.0));
      CHECK(chart_probability(1.001 * t, n) <= sixty);
      CHECK(chart_probability(-t, n) == sixty);
    }
  CHECK(chart_probability(student_quantile(1.0 - 0.5e-2, 7.0), 8) == Approx(1e-2 * 10.49));
  CHECK(chart_probability(student_quantile(1.0 - 0.5e-2, 29.0), 30) == Approx(1e-2 * 22.15));
  CHECK(chart_probability(0.0, 8) == 1.0);
  CHECK(chart_probability(INFINITY, 8) == 0.0);
}

TEST_CASE("of eight runs' baselines a step of two deviations is found in 80 % at today's 4.6 % of false alarms") {
  std::mt19937_64 random(20261123);
  std::normal_distribution<double> normal;
  constexpr int kDrawnHistories = 12000;
  const auto alarms = [&](double step) {
    int found = 0;
    for (int history = 0; history < kDrawnHistories; ++history) {
      std::array<double, 8> start_up{};
      for (double& value : start_up) value = normal(random);
      EwmaChart chart = *EwmaChart::begin(start_up);
      double largest = 0.0;
      for (int run = 0; run < 60; ++run) {
        chart.add(normal(random) + step);
        largest = std::max(largest, std::abs(chart.state().statistic));
      }
      found += chart_probability(largest, 8) <= 0.042 ? 1 : 0;
    }
    return 100.0 * found / kDrawnHistories;
  };
  const double sound = alarms(0.0), shifted = alarms(2.0);
  CHECK(sound <= 4.6);
  CHECK(sound == Approx(4.2).margin(0.6));  // three standard errors
  CHECK(shifted >= 80.0);
}

TEST_CASE("figures are means or maxima by their names") {
  for (const char* name : {"hysteresis_max_percent_fs", "max_error_psi", "worst_taxel_error_psi", "noisiest_taxel_mv",
                           "overshoot_psi", "repeatability_psi", "stage_repeatability_um"})
    CHECK(figure_kind(name) == FigureKind::kMaximum);
  for (const char* name : {"mean_error_psi", "hysteresis_mean_percent_fs", "hold_noise_psi", "frames",
                           "regulator_hysteresis_psi", "hold_drift_psi_per_min", "force_zero_drift_n"})
    CHECK(figure_kind(name) == FigureKind::kMean);
  CHECK(figure_kind("nobody_knows") == FigureKind::kMean);
}

TEST_CASE("a maximum is charted by its logarithm, as long as it is above zero") {
  std::vector<double> start_up, later = {std::exp(12.0), std::exp(13.0)};
  for (const double value : kStartUp) start_up.push_back(std::exp(value));
  FigureChart chart = chart_figure("max_error_psi", start_up, later);
  REQUIRE((chart.ewma && chart.band));
  CHECK(chart.logarithmic);
  CHECK(chart.ewma->ewma == Approx(0.92));
  CHECK(chart.level == Approx(std::exp(10.92)));
  const double half = student_quantile(1.0 - 0.5e-5, 7.0) * std::sqrt(1.125);
  CHECK(chart.band->high == Approx(std::exp(10.0 + half)));
  CHECK(chart.band->mean == Approx(control_band(start_up, 0.5)->mean));
  CHECK(chart.probability == Approx(chart_probability(0.92 / std::sqrt(0.0818), 8)));
  CHECK_FALSE(chart_figure("mean_error_psi", start_up, later).logarithmic);
  later.push_back(0.0);
  CHECK_FALSE(chart_figure("max_error_psi", start_up, later).logarithmic);
}

TEST_CASE("constants are compared exactly and not charted, counts that varied are") {
  const std::vector<double> same(8, 3310.0), later = {3310.0, 3309.0};
  FigureChart chart = chart_figure("frames", same, later);
  CHECK((chart.constant && !chart.ewma));
  CHECK((chart.band->holds(3310.0) && !chart.band->holds(3309.0)));
  std::vector<double> varied = same;
  varied.front() = 3311.0;
  CHECK(chart_figure("frames", varied, later).ewma);
  CHECK_FALSE(chart_figure("mean_error_psi", std::span(kStartUp).first(7), later).ewma);
  CHECK(chart_figure("mean_error_psi", std::span(kStartUp).first(7), later).band);
  CHECK_FALSE(chart_figure("mean_error_psi", std::span(kStartUp).first(2), later).band);
  CHECK_FALSE(chart_figure("mean_error_psi", kStartUp, {}).ewma);
}

TEST_CASE("Benjamini and Hochberg: their own example, and edges") {
  // Benjamini and Hochberg 1995, section 4: of fifteen comparisons four are rejected at 0.05.
  const std::array p = {0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                        0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  const std::vector<bool> reported = discoveries(p);
  CHECK(std::ranges::count(reported, true) == 4);
  CHECK((reported[3] && !reported[4]));
  CHECK(discoveries(std::array{0.9, 0.04, 0.02}) == std::vector<bool>{false, false, false});
  CHECK(discoveries(std::array{0.9, 0.033, 0.02}) == std::vector<bool>{false, true, true});  // up to the largest k
  CHECK(discoveries(std::array{0.05}) == std::vector<bool>{true});
  CHECK(discoveries(std::array{0.05, 0.05}) == std::vector<bool>{true, true});
  CHECK(discoveries(std::array{0.025, 0.5}) == std::vector<bool>{true, false});  // 0.05 x 1 / 2
  CHECK(discoveries(std::array{0.0251, 0.5}) == std::vector<bool>{false, false});
  CHECK(discoveries(std::array{0.2, 0.1}, 0.2) == std::vector<bool>{true, true});
  CHECK(discoveries(std::array{0.3, 0.11}, 0.2) == std::vector<bool>{false, false});
  CHECK(discoveries({}).empty());
}
