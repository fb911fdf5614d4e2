// The table that charts rest on, entry by entry, and what a figure's chart takes of its runs: by hand.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/statistics/control/control_band.h"
#include "analysis/statistics/control/ewma_chart.h"
#include "analysis/statistics/control/false_discovery.h"
#include "analysis/statistics/control/figure_chart.h"
#include "analysis/statistics/numbers/student.h"

using namespace tactbench::analysis;

namespace {

// Mean 10, deviation 1.
const std::vector<double> kEightRuns{9.0, 11.0, 9.0, 11.0, 10.0 - std::sqrt(1.5), 10.0 + std::sqrt(1.5), 10.0, 10.0};

// As simulated (ewma_table_slow.cpp draws it again): rows by runs of the baseline, columns by half decades of the
// probability of one run. A wrong digit alarms too often or too seldom by a few percent, which no draw would show.
constexpr int kVeryMany = std::numeric_limits<int>::max();
constexpr std::array<int, 8> kBaselines = {8, 10, 12, 15, 20, 30, 60, kVeryMany};
constexpr std::array<std::array<double, 13>, 8> kSimulated = {{
    {1, 3.069, 6.149, 8.650, 10.49, 11.82, 12.78, 13.47, 13.96, 14.32, 14.57, 14.75, 14.89},
    {1, 3.112, 6.747, 10.01, 12.57, 14.54, 16.03, 17.17, 18.05, 18.71, 19.22, 19.61, 19.92},
    {1, 3.132, 7.185, 11.10, 14.29, 16.80, 18.77, 20.32, 21.54, 22.51, 23.27, 23.88, 24.37},
    {1, 3.147, 7.661, 12.40, 16.38, 19.59, 22.16, 24.22, 25.89, 27.23, 28.33, 29.22, 29.95},
    {1, 3.156, 8.166, 13.96, 18.96, 23.02, 26.29, 28.94, 31.12, 32.92, 34.43, 35.71, 36.79},
    {1, 3.160, 8.678, 15.83, 22.15, 27.22, 31.25, 34.45, 36.99, 39.02, 40.63, 41.89, 42.84},
    {1, 3.162, 9.167, 18.09, 26.14, 32.31, 36.89, 40.40, 43.18, 45.39, 47.16, 48.60, 49.83},
    {1, 3.162, 9.575, 20.62, 30.89, 37.87, 42.87, 46.02, 48.76, 50.14, 52.11, 53.52, 54.45},
}};

double in_sixty(double one_run, int runs) {
  return chart_probability(student_quantile(1.0 - one_run / 2.0, runs - 1.0), runs);
}

}  // namespace

TEST_CASE("charts: what sixty runs are worth, at each half decade and number of runs of the table") {
  for (std::size_t row = 0; row < kBaselines.size(); ++row)
    for (std::size_t column = 0; column < 13; ++column) {
      INFO(kBaselines[row] << " runs, half decade " << column);
      const double one_run = column == 0 ? 1.0 - 1e-12 : std::pow(10.0, -0.5 * static_cast<double>(column));
      CHECK(in_sixty(one_run, kBaselines[row]) / one_run == Approx(kSimulated[row][column]).epsilon(1e-5));
    }
}

TEST_CASE("charts: between the table's entries, linear in half decades and in one over the runs, constant beyond") {
  // A quarter of a decade below 1 of 8 runs: half way from 6.149 to 8.650 at 10^-1.25.
  CHECK(in_sixty(std::pow(10.0, -1.25), 8) / std::pow(10.0, -1.25) == Approx((6.149 + 8.650) / 2));
  // 1 / 9 lies between 1 / 8 and 1 / 10 by 5 / 9 of the way.
  CHECK(in_sixty(0.01, 9) / 0.01 == Approx(10.49 + 5.0 / 9.0 * (12.57 - 10.49)));
  // 120 runs: half way from 60 to no end.
  CHECK(in_sixty(0.01, 120) / 0.01 == Approx((26.14 + 30.89) / 2));
  CHECK(in_sixty(0.01, 59) / 0.01 == Approx(26.14 - (1.0 / 59 - 1.0 / 60) / (1.0 / 30 - 1.0 / 60) * (26.14 - 22.15)));
  CHECK(in_sixty(1e-7, 8) / 1e-7 == Approx(14.89));
  CHECK(in_sixty(1e-9, 8) / 1e-9 == Approx(14.89).epsilon(1e-4));
}

TEST_CASE("charts: a mean's level is its average in its own unit, gross values alone leave no chart") {
  const FigureChart chart = chart_figure("mean_error_psi", kEightRuns, std::vector<double>{12.0, 13.0});
  REQUIRE(chart.ewma);
  CHECK((chart.kind == FigureKind::kMean && !chart.logarithmic && !chart.constant));
  CHECK(chart.level == Approx(10.92));  // z of 0.92 deviations of 1
  CHECK(chart.ewma->later == 2);
  const FigureChart gross = chart_figure("mean_error_psi", kEightRuns, std::vector<double>{1000.0});
  CHECK_FALSE(gross.ewma);
  CHECK(gross.probability == 1.0);
  CHECK(gross.level == 0.0);
  CHECK(gross.band);
  // A maximum of 0 in the baseline has no logarithm either.
  std::vector<double> with_zero = kEightRuns;
  with_zero[0] = 0.0;
  CHECK_FALSE(chart_figure("max_error_psi", with_zero, std::vector<double>{12.0}).logarithmic);
  CHECK(chart_figure("max_error_psi", kEightRuns, std::vector<double>{12.0}).logarithmic);
  CHECK(chart_figure("max_error_psi", with_zero, std::vector<double>{12.0}).kind == FigureKind::kMaximum);
}

TEST_CASE("charts: the slope is that of the last fourteen runs") {
  const std::vector<double> later{90, 3, 14, 15, 9, 26, 5, 35, 8, 97, 93, 23, 84, 62, 64, 33};
  const auto slope_of = [&](std::size_t last) { return theil_sen_slope(std::span(later).last(last)); };
  const auto slope = chart_figure("mean_error_psi", kEightRuns, later).slope;
  CHECK(slope == slope_of(14));
  CHECK(slope != slope_of(13));
  CHECK(slope != slope_of(15));
  CHECK(chart_figure("mean_error_psi", kEightRuns, std::span(later).first(4)).slope ==
        theil_sen_slope(std::span(later).first(4)));
  CHECK_FALSE(chart_figure("mean_error_psi", kEightRuns, std::span(later).first(3)).slope);
}

TEST_CASE("charts: a deviation of less than a billionth of the mean is none") {
  const auto with_deviation = [](double share) {
    std::vector<double> runs = kEightRuns;
    for (double& run : runs) run = 1000.0 + 1000.0 * share * (run - 10.0);
    return runs;
  };
  CHECK(EwmaChart::begin(with_deviation(2e-9)));
  CHECK_FALSE(EwmaChart::begin(with_deviation(0.5e-9)));
  CHECK_FALSE(chart_figure("frames", with_deviation(2e-9), {}).constant);
  CHECK(chart_figure("frames", with_deviation(0.5e-9), {}).constant);
  const auto band = control_band(with_deviation(0.0), 0.05);
  CHECK(band->low == Approx(1000.0 - 1e-6).epsilon(1e-12));
  CHECK(band->high == Approx(1000.0 + 1e-6).epsilon(1e-12));
  CHECK(band->values == 8);
  const auto negative = control_band(std::vector<double>(3, -7.0), 0.05);
  CHECK((negative->holds(-7.0 + 6e-9) && !negative->holds(-7.0 + 8e-9)));
}

TEST_CASE("control band by hand: the false alarms asked for, of three values") {
  // 1, 2, 3: mean 2, deviation 1; t of two degrees of freedom 4.302653 at 5 %, 9.924843 at 1 %.
  const std::vector<double> three{3.0, 1.0, 2.0};
  CHECK(control_band(three, 0.05)->low == Approx(2.0 - 4.302653 * std::sqrt(4.0 / 3.0)));
  CHECK(control_band(three, 0.01)->high == Approx(2.0 + 9.924843 * std::sqrt(4.0 / 3.0)));
  CHECK(control_band(three, 0.05)->holds(control_band(three, 0.05)->high));
}

TEST_CASE("discoveries by hand: at the limit itself, ties, and any number of them") {
  CHECK(discoveries(std::vector<double>{0.025, 0.5}) == std::vector<bool>{true, false});  // 0.05 x 1 / 2
  CHECK(discoveries(std::vector<double>{0.0251, 0.5}) == std::vector<bool>{false, false});
  CHECK(discoveries(std::vector<double>{0.05, 0.05}) == std::vector<bool>{true, true});
  CHECK(discoveries(std::vector<double>{0.0, 1.0}) == std::vector<bool>{true, false});
  CHECK(discoveries(std::vector<double>{0.2, 0.1}, 0.2) == std::vector<bool>{true, true});
  CHECK(discoveries(std::vector<double>{0.3, 0.11}, 0.2) == std::vector<bool>{false, false});
}
