// Between the entries of the table that charts rest on, and what a figure's chart takes of its runs: by hand.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "analysis/statistics/control/control_chart.h"
#include "analysis/statistics/numbers/moments.h"

using namespace tactbench::analysis;

namespace {

// Mean 10, sum of squares 7, so that the deviation is 1.
const std::vector<double> kStartUp{9.0, 11.0, 9.0, 11.0, 10.0 - std::sqrt(1.5), 10.0 + std::sqrt(1.5), 10.0, 10.0};

// The table is drawn again in sensor_slow.cpp.
double in_sixty(double one_run, int runs) {
  return ewma_probability(student_quantile(1.0 - one_run / 2.0, runs - 1.0), runs);
}

}  // namespace

TEST_CASE("EWMA chart: table probabilities are interpolated in half decades and 1/runs, and constant beyond") {
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

TEST_CASE("EWMA chart: a mean's level is the average in the mean's unit, gross values alone give no chart") {
  const ControlChart chart = control_chart("mean_error_psi", kStartUp, std::vector<double>{12.0, 13.0});
  REQUIRE(chart.ewma);
  CHECK((chart.kind == FigureKind::kMean && !chart.logarithmic && !chart.constant));
  CHECK(chart.level == Approx(10.92));  // z of 0.92 deviations of 1
  CHECK(chart.ewma->later == 2);
  const ControlChart gross = control_chart("mean_error_psi", kStartUp, std::vector<double>{1000.0});
  CHECK_FALSE(gross.ewma);
  CHECK(gross.probability == 1.0);
  CHECK(gross.level == 0.0);
  CHECK(gross.band);
  // A maximum of 0 in the baseline has no logarithm either.
  std::vector<double> with_zero = kStartUp;
  with_zero[0] = 0.0;
  CHECK_FALSE(control_chart("max_error_psi", with_zero, std::vector<double>{12.0}).logarithmic);
  CHECK(control_chart("max_error_psi", kStartUp, std::vector<double>{12.0}).logarithmic);
  CHECK(control_chart("max_error_psi", with_zero, std::vector<double>{12.0}).kind == FigureKind::kMaximum);
}

TEST_CASE("EWMA chart: the slope is that of the last 14 runs") {
  const std::vector<double> later{90, 3, 14, 15, 9, 26, 5, 35, 8, 97, 93, 23, 84, 62, 64, 33};
  const auto slope_of = [&](std::size_t last) { return theil_sen_slope(std::span(later).last(last)); };
  const auto slope = control_chart("mean_error_psi", kStartUp, later).slope;
  CHECK(slope == slope_of(14));
  CHECK(slope != slope_of(13));
  CHECK(slope != slope_of(15));
  CHECK(control_chart("mean_error_psi", kStartUp, std::span(later).first(4)).slope ==
        theil_sen_slope(std::span(later).first(4)));
  CHECK_FALSE(control_chart("mean_error_psi", kStartUp, std::span(later).first(3)).slope);
}

TEST_CASE("EWMA chart: a deviation below 1e-9 of the mean counts as none") {
  const auto with_deviation = [](double share) {
    std::vector<double> runs = kStartUp;
    for (double& run : runs) run = 1000.0 + 1000.0 * share * (run - 10.0);
    return runs;
  };
  CHECK(EwmaControlChart::begin(with_deviation(2e-9)));
  CHECK_FALSE(EwmaControlChart::begin(with_deviation(0.5e-9)));
  CHECK_FALSE(control_chart("frames", with_deviation(2e-9), {}).constant);
  CHECK(control_chart("frames", with_deviation(0.5e-9), {}).constant);
  const auto band = control_band(with_deviation(0.0), 0.05);
  CHECK(band->low == Approx(1000.0 - 1e-6).epsilon(1e-12));
  CHECK(band->high == Approx(1000.0 + 1e-6).epsilon(1e-12));
  CHECK(band->values == 8);
  const auto negative = control_band(std::vector<double>(3, -7.0), 0.05);
  CHECK((negative->holds(-7.0 + 6e-9) && !negative->holds(-7.0 + 8e-9)));
}

// Control bands and slopes against published and exactly computed values, and the promised rate of false alarms.

TEST_CASE("Student quantiles: match the published tables") {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const std::pair<double, double> published[] = {
      {student_quantile(0.975, 10.0), 2.228139},
      {student_quantile(0.995, 1.0), 63.65674},
      {student_quantile(0.025, 4.0), -2.776445},
      {student_quantile(0.975, kEndless), 1.959964},
      {student_two_sided(-2.228139, 10.0), 0.05},
      {student_two_sided(1.959964, kEndless), 0.05},
      // Of one degree of freedom, Cauchy's distribution: 1/2 beyond 1, and the quantile at 3/4 is 1.
      {student_two_sided(1.0, 1.0), 0.5},
      {student_quantile(0.75, 1.0), 1.0}};
  for (const auto& [found, expected] : published) CHECK(found == Approx(expected).epsilon(1e-6));
  CHECK(student_two_sided(kEndless, 3.0) == 0.0);
  // Of a half and 1e300 degrees of freedom there are some, too, and none of -1 or of no t.
  CHECK(student_two_sided(0.0, 0.5) == 1.0);
  CHECK(student_quantile(0.5, 0.5) == Approx(0.0).margin(1e-12));
  for (const double none :
       {student_quantile(1.0, 4.0), student_quantile(0.5, 0.0), student_quantile(0.0, 4.0), student_two_sided(1.0, 0.0),
        student_two_sided(1.0, -1.0), student_two_sided(std::nan(""), 3.0)})
    CHECK(std::isnan(none));
}

TEST_CASE("control band: is the prediction interval of a normal sample") {
  const auto band = control_band(std::array{1.0, 2.0, 3.0, 4.0, 5.0}, 0.05);
  REQUIRE(band);
  CHECK(band->mean == 3.0);
  CHECK(band->deviation == Approx(1.5811388));
  CHECK(band->high == Approx(3.0 + 2.776445 * 1.5811388 * std::sqrt(1.2)));
  CHECK(control_band(std::array{1.0, 2.0, 3.0}, 0.01)->high == Approx(2.0 + 9.924843 * std::sqrt(4.0 / 3.0)));
  CHECK((band->holds(band->low) && !band->holds(band->low - 1e-6)));
  CHECK_FALSE(control_band(std::array{1.0, 2.0}, 0.05));
  CHECK_FALSE(control_band(std::array{1.0, 2.0, std::nan("")}, 0.05));
  const auto alike = control_band(std::array{7.0, 7.0, 7.0}, 0.05);
  REQUIRE(alike);
  CHECK((alike->holds(7.0 + 1e-9) && !alike->holds(7.0 + 1e-7)));
}

TEST_CASE("control band: values from the baseline's distribution fall outside at the stated rate") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(3.0, 0.2);
  int outside = 0;
  constexpr int kTrials = 20000;
  for (int i = 0; i < kTrials; ++i) {
    std::array<double, 8> values{};
    for (double& value : values) value = normal(random);
    outside += control_band(values, 0.02)->holds(normal(random)) ? 0 : 1;
  }
  CHECK(outside / double(kTrials) == Approx(0.02).margin(0.004));  // four standard errors
}

TEST_CASE("Theil-Sen slope: is the median of the slopes between any two values") {
  CHECK(theil_sen_slope(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0}) == 1.0);
  CHECK(theil_sen_slope(std::array{4.0, 3.0, 2.0, 1.0}) == -1.0);
  CHECK(*theil_sen_slope(std::array{1.0, 4.0, 2.0, 3.0}) == Approx(7.0 / 12.0));  // -2, -0.5, 0.5, 2/3, 1, 3
  CHECK(theil_sen_slope(std::vector<double>(9, 4.0)) == 0.0);
  CHECK_FALSE(theil_sen_slope(std::array{1.0, 2.0, 3.0}));
  CHECK_FALSE(theil_sen_slope(std::array{1.0, 2.0, 3.0, std::nan("")}));
}

// The chart of one figure against values computed by hand, and its promised rates of false alarms and of shifts found.

TEST_CASE("EWMA chart: the first three runs match hand-computed values") {
  std::optional<EwmaControlChart> chart = EwmaControlChart::begin(kStartUp);
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

TEST_CASE("EWMA chart: gross values stay out of the average, short and constant baselines give no chart") {
  std::optional<EwmaControlChart> chart = EwmaControlChart::begin(kStartUp);
  const double limit = student_quantile(1.0 - 0.5e-5, 7.0) * std::sqrt(1.125);
  chart->add(10.0 - 1.001 * limit);
  CHECK((chart->state().ewma == 0.0 && chart->state().later == 0 && chart->probability() == 1.0));
  chart->add(10.0 - 0.999 * limit);
  CHECK(chart->state().ewma == Approx(-0.2 * 0.999 * limit));
  CHECK_FALSE(EwmaControlChart::begin(std::span(kStartUp).first(7)));
  CHECK_FALSE(EwmaControlChart::begin(std::vector<double>(8, 4.0)));
}

TEST_CASE("EWMA chart: the probability over 60 runs lies between that of one run and 60 times it") {
  for (const int n : {8, 9, 25, 60, 500})
    for (double one = 0.9; one > 1e-12; one *= 0.37) {
      const double t = student_quantile(1.0 - one / 2.0, n - 1.0), sixty = ewma_probability(t, n);
      INFO(n << " " << one);
      CHECK((sixty >= one && sixty <= 60.0 * one && sixty <= 1.0));
      CHECK(ewma_probability(1.001 * t, n) <= sixty);
      CHECK(ewma_probability(-t, n) == sixty);
    }
  CHECK(ewma_probability(student_quantile(1.0 - 0.5e-2, 7.0), 8) == Approx(1e-2 * 10.49));
  CHECK(ewma_probability(student_quantile(1.0 - 0.5e-2, 29.0), 30) == Approx(1e-2 * 22.15));
  CHECK(ewma_probability(0.0, 8) == 1.0);
  CHECK(ewma_probability(INFINITY, 8) == 0.0);
}

TEST_CASE("EWMA chart: eight baseline runs find a step of two deviations in 80 %, at 4.6 % false alarms") {
  std::mt19937_64 random(20261123);
  std::normal_distribution<double> normal;
  constexpr int kDrawnHistories = 12000;
  const auto alarms = [&](double step) {
    int found = 0;
    for (int history = 0; history < kDrawnHistories; ++history) {
      std::array<double, 8> start_up{};
      for (double& value : start_up) value = normal(random);
      EwmaControlChart chart = *EwmaControlChart::begin(start_up);
      double largest = 0.0;
      for (int run = 0; run < 60; ++run) {
        chart.add(normal(random) + step);
        largest = std::max(largest, std::abs(chart.state().statistic));
      }
      found += ewma_probability(largest, 8) <= 0.042 ? 1 : 0;
    }
    return 100.0 * found / kDrawnHistories;
  };
  const double sound = alarms(0.0), shifted = alarms(2.0);
  CHECK(sound <= 4.6);
  CHECK(sound == Approx(4.2).margin(0.6));  // three standard errors
  CHECK(shifted >= 80.0);
}

TEST_CASE("EWMA chart: the name of a value decides whether it is a mean or a maximum") {
  for (const char* name : {"hysteresis_max_percent_fs", "max_error_psi", "worst_taxel_error_psi", "noisiest_taxel_mv",
                           "overshoot_psi", "repeatability_psi", "stage_repeatability_um"})
    CHECK(figure_kind(name) == FigureKind::kMaximum);
  for (const char* name : {"mean_error_psi", "hysteresis_mean_percent_fs", "hold_noise_psi", "frames",
                           "regulator_hysteresis_psi", "hold_drift_psi_per_min", "force_zero_drift_n"})
    CHECK(figure_kind(name) == FigureKind::kMean);
  CHECK(figure_kind("nobody_knows") == FigureKind::kMean);
}

TEST_CASE("EWMA chart: a maximum is charted by its logarithm if all values are above zero") {
  std::vector<double> start_up, later = {std::exp(12.0), std::exp(13.0)};
  for (const double value : kStartUp) start_up.push_back(std::exp(value));
  ControlChart chart = control_chart("max_error_psi", start_up, later);
  REQUIRE((chart.ewma && chart.band));
  CHECK(chart.logarithmic);
  CHECK(chart.ewma->ewma == Approx(0.92));
  CHECK(chart.level == Approx(std::exp(10.92)));
  const double half = student_quantile(1.0 - 0.5e-5, 7.0) * std::sqrt(1.125);
  CHECK(chart.band->high == Approx(std::exp(10.0 + half)));
  CHECK(chart.band->mean == Approx(control_band(start_up, 0.5)->mean));
  CHECK(chart.probability == Approx(ewma_probability(0.92 / std::sqrt(0.0818), 8)));
  CHECK_FALSE(control_chart("mean_error_psi", start_up, later).logarithmic);
  later.push_back(0.0);
  CHECK_FALSE(control_chart("max_error_psi", start_up, later).logarithmic);
}

TEST_CASE("EWMA chart: constants are compared exactly and not charted, counts that varied are charted") {
  const std::vector<double> same(8, 3310.0), later = {3310.0, 3309.0};
  ControlChart chart = control_chart("frames", same, later);
  CHECK((chart.constant && !chart.ewma));
  CHECK((chart.band->holds(3310.0) && !chart.band->holds(3309.0)));
  std::vector<double> varied = same;
  varied.front() = 3311.0;
  CHECK(control_chart("frames", varied, later).ewma);
  CHECK_FALSE(control_chart("mean_error_psi", std::span(kStartUp).first(7), later).ewma);
  CHECK(control_chart("mean_error_psi", std::span(kStartUp).first(7), later).band);
  CHECK_FALSE(control_chart("mean_error_psi", std::span(kStartUp).first(2), later).band);
  CHECK_FALSE(control_chart("mean_error_psi", kStartUp, {}).ewma);
}

TEST_CASE("Benjamini and Hochberg: their published example and the edge cases are reproduced") {
  // Benjamini and Hochberg 1995, section 4: of fifteen comparisons four are rejected at 0.05.
  const std::array p = {0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                        0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  const std::vector<bool> reported = discoveries(p);
  CHECK(std::ranges::count(reported, true) == 4);
  CHECK((reported[3] && !reported[4]));
  struct Row {
    std::vector<double> p;
    double rate;
    std::vector<bool> found;
  };
  const Row rows[] = {{{0.9, 0.04, 0.02}, 0.05, {false, false, false}},
                      {{0.9, 0.033, 0.02}, 0.05, {false, true, true}},  // up to the largest k
                      {{0.05}, 0.05, {true}},
                      {{0.05, 0.05}, 0.05, {true, true}},
                      {{0.025, 0.5}, 0.05, {true, false}},  // 0.05 x 1 / 2
                      {{0.0251, 0.5}, 0.05, {false, false}},
                      {{0.2, 0.1}, 0.2, {true, true}},
                      {{0.3, 0.11}, 0.2, {false, false}}};
  for (const Row& row : rows) CHECK(discoveries(row.p, row.rate) == row.found);
  CHECK(discoveries({}).empty());
}
