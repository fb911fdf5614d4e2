// Between the entries of the table that charts rest on, and what a figure's chart takes of its runs: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/statistics/control/control_band.h"
#include "analysis/statistics/control/ewma_chart.h"
#include "analysis/statistics/control/figure_chart.h"
#include "analysis/statistics/numbers/student.h"

using namespace tactbench::analysis;

namespace {

// Mean 10, deviation 1.
const std::vector<double> kEightRuns{9.0, 11.0, 9.0, 11.0, 10.0 - std::sqrt(1.5), 10.0 + std::sqrt(1.5), 10.0, 10.0};

// The table is drawn again in ewma_table_slow.cpp.
double in_sixty(double one_run, int runs) {
  return chart_probability(student_quantile(1.0 - one_run / 2.0, runs - 1.0), runs);
}

}  // namespace

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
