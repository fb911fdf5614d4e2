// Drift of a sensor against its model, on two taxels of output = input and later data of four points at inputs 0, 0, 4,
// 4; health of taxels and lines.

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <memory>

#include "analysis/identify/histories.h"
#include "analysis/models/monotone.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/scoring/score.h"
#include "analysis/statistics/sensor/drift.h"
#include "analysis/statistics/sensor/health.h"
#include "tests/analysis/support/specimen_taxels.h"

using namespace tactbench::analysis;

namespace {

ModelTaxel unit_line(int number) {
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  const std::vector<double> ends{0.0, 10.0};
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, ends, 0.0, 10.0));
  taxel.fit.full_scale = 10.0;
  taxel.fit.mean_error = 0.15;
  taxel.ascending = taxel.descending = PatternCurve(ends, ends, 0.0, 10.0);
  return taxel;
}

SensorModel two_taxels() {
  SensorModel document;
  document.model = "monotone";
  document.input_unit = "psi";
  document.output_unit = "V";
  document.columns = 2;
  for (const int number : {0, 1, kMeanTaxel}) document.taxels.push_back(unit_line(number));
  return document;
}

TaxelHistories later(int number, std::vector<double> x, std::vector<double> y) {
  TaxelHistories taxel;
  taxel.taxel = number;
  History history;
  history.branches = branches_along(x);
  history.x = std::move(x);
  history.y = std::move(y);
  taxel.score = {std::move(history)};
  return taxel;
}

// The first taxel has a zero of 1 and a gain of 2, with residuals of +0.1 and -0.1 at either end; the second a zero of
// 0.5 and nothing else.
Histories later_data() {
  Histories histories;
  histories.columns = 2;
  histories.content_sha256 = "0123456789abcdef";
  histories.taxels.push_back(later(0, {0, 0, 4, 4}, {1.1, 0.9, 9.1, 8.9}));
  histories.taxels.push_back(later(1, {0, 0, 4, 4}, {0.5, 0.5, 4.5, 4.5}));
  return histories;
}

}  // namespace

TEST_CASE("drift: zero, gain, their uncertainties and the error after each adjustment match hand-computed values") {
  const Drift drift = drift_of(two_taxels(), later_data(), 0.02);
  REQUIRE(drift.taxels.size() == 2);
  const TaxelDrift& first = drift.taxels[0];
  CHECK(first.zero == Approx(1.0));
  CHECK(first.gain == Approx(2.0));
  CHECK(first.zero_alone == Approx(3.0));  // the means are 5 and 2
  // Residual variance 4 x 0.01 / 2 = 0.02; inputs have squares of 16 about their mean of 2.
  CHECK(first.gain_u == Approx(std::sqrt(0.02 / 16.0)));
  CHECK(first.zero_u == Approx(0.1));  // 0.02 / 4 and (2 gain_u)^2 = 0.005 each
  CHECK(first.as_is == Approx(0.3));   // 1.1, 0.9, 5.1, 4.9 of a full scale of 10
  CHECK(first.zeroed == Approx(0.2));  // 1.9, 2.1, 2.1, 1.9
  CHECK(first.adjusted == Approx(0.01));
  const TaxelDrift& second = drift.taxels[1];
  CHECK(second.zero_alone == Approx(0.5));
  CHECK(second.zero_u == Approx(0.0).margin(1e-12));
  CHECK(second.as_is == Approx(0.05));
  CHECK(second.zeroed == Approx(0.0).margin(1e-12));
  CHECK(drift.as_is == Approx(0.175));
  CHECK(drift.zeroed == Approx(0.1));
  CHECK(drift.adjusted == Approx(0.005));
  // Of the array: zeros of 0.1 and 0.05 of full scale, gains of 2 and 1.
  CHECK(drift.zero == Approx(0.075));
  CHECK(drift.zero_u == Approx(2.0 * std::hypot(0.5 * 0.01, 0.025, 0.005 / std::sqrt(3.0))));
  CHECK(drift.gain == Approx(0.5));
  CHECK(drift.gain_u == Approx(2.0 * std::hypot(0.5 * std::sqrt(0.02 / 16.0), 0.5, 0.005 / std::sqrt(3.0))));
}

TEST_CASE("drift: the verdict follows from the error left within the tolerance, by default twice the fit's error") {
  const Histories data = later_data();  // 17.5 % as it is, 10 % with zero, 0.5 % with zero and gain
  CHECK(drift_of(two_taxels(), data, 0.18).verdict == DriftVerdict::kGood);
  CHECK(drift_of(two_taxels(), data, 0.17).verdict == DriftVerdict::kZero);
  CHECK(drift_of(two_taxels(), data, 0.09).verdict == DriftVerdict::kGain);
  CHECK(drift_of(two_taxels(), data, 0.004).verdict == DriftVerdict::kRecalibrate);
  CHECK(drift_of(two_taxels(), data).tolerance == Approx(0.03));  // 0.15 of 10, twice
  SensorModel exact = two_taxels();
  for (ModelTaxel& taxel : exact.taxels) taxel.fit.mean_error = 0.0;
  CHECK(drift_of(exact, data).tolerance == Approx(0.005));
}

TEST_CASE("drift: the verdict names the part that moved, even where a zero shift resembles a gain change") {
  struct Row {
    double zero, gain;
    DriftVerdict verdict;
  };
  constexpr double kOutputNoise = 0.01;
  // Inputs of 2 and 4: a gain of 0.9 is off by 0.2 and 0.4, and by 0.1 once a zero of -0.3 is taken off.
  for (const Row& row : {Row{0.3, 1.0, DriftVerdict::kZero}, Row{0.0, 0.9, DriftVerdict::kGain},
                         Row{0.6, 0.9, DriftVerdict::kGain}, Row{-1.0, 0.95, DriftVerdict::kZero}}) {
    Histories data;
    data.columns = 2;
    for (const int taxel : {0, 1}) {
      const double low = row.zero + 2 * row.gain, high = row.zero + 4 * row.gain;
      data.taxels.push_back(later(taxel, {2, 2, 4, 4},
                                  {low + kOutputNoise, low - kOutputNoise, high + kOutputNoise, high - kOutputNoise}));
    }
    const Drift drift = drift_of(two_taxels(), data, 0.015);
    INFO(row.zero << " " << row.gain);
    CHECK(drift.zeroed <= 0.015);
    CHECK(drift.verdict == row.verdict);
    CHECK(drift.zero_moved() == (row.zero != 0.0));
    CHECK(drift.gain_moved() == (row.gain != 1.0));
  }
}

TEST_CASE("drift: a gain is fitted only if the inputs cover a tenth of the model's range") {
  Histories narrow;
  narrow.taxels.push_back(later(0, {0, 0, 0.9, 0.9}, {1.0, 1.0, 2.8, 2.8}));
  const TaxelDrift drift = drift_of(two_taxels(), narrow).taxels.front();
  CHECK(drift.gain == 1.0);
  CHECK(drift.gain_u == 0.0);
  CHECK(drift.zero == Approx(1.45));  // of means 1.9 and 0.45
  // Residuals -0.45 and +0.45: variance 4 x 0.2025 / 2, of the mean of four.
  CHECK(drift.zero_u == Approx(std::sqrt(0.405 / 4.0)));
  // Two samples leave no degree of freedom, and one counts: residuals of -0.5 and 0.5; 0.5 over one, of two.
  Histories two;
  two.taxels.push_back(later(0, {3, 3.5}, {7, 8.5}));
  const TaxelDrift of_two = drift_of(two_taxels(), two).taxels.front();
  CHECK(of_two.gain == 1.0);
  CHECK(of_two.zero == Approx(4.5));
  CHECK(of_two.zero_u == Approx(std::sqrt(0.5 / 2)));
  CHECK(of_two.as_is == Approx((4.0 + 5.0) / 2 / 10));
  CHECK(of_two.zeroed == Approx(0.05));
}

TEST_CASE("drift adjustment: uses zero and gain of each taxel, and their means for the mean taxel") {
  const Histories data = later_data();
  const Drift drift = drift_of(two_taxels(), data);
  const SensorModel both = adjusted(two_taxels(), drift, data, true);
  CHECK(both.taxel(0).zero == Approx(1.0));
  CHECK(both.taxel(0).gain == Approx(2.0));
  CHECK(both.taxel(1).zero == Approx(0.5));
  CHECK(both.taxel(kMeanTaxel).zero == Approx(0.75));
  CHECK(both.taxel(kMeanTaxel).gain == Approx(1.5));
  const SensorModel zero = adjusted(two_taxels(), drift, data, false);
  CHECK(zero.taxel(0).zero == Approx(3.0));
  CHECK(zero.taxel(0).gain == 1.0);
  CHECK(zero.taxel(kMeanTaxel).zero == Approx(1.75));
  CHECK(zero.taxel(kMeanTaxel).gain == 1.0);
  CHECK(drift_of(both, data).as_is == Approx(0.005));
  // Its loop moves with it; adjusted once more from there, by the same data, it is the model as it was fitted, moved.
  CHECK(both.taxel(0).y0() == Approx(1.0));
  CHECK(both.taxel(0).yu() == Approx(21.0));
  CHECK(zero.taxel(0).y0() == Approx(3.0));
  CHECK(zero.taxel(0).yu() == Approx(13.0));
  const SensorModel again = adjusted(zero, drift_of(zero, data), data, true);
  CHECK(again.taxel(0).y0() == Approx(1.0));
  CHECK(again.taxel(0).yu() == Approx(21.0));
  CHECK(both.parent_sha256 == sha256_of(two_taxels()));
  for (const SensorModel* made : {&both, &zero}) CHECK_THAT(made->adjustment, Catch::Contains("0123456789ab"));
}

// Health of taxels and lines at each limit: by hand.

namespace {

// One taxel each, whose outputs run from `low` to `high`.
struct Extremes {
  double low_v, high_v;
  bool at_limit = false;
  double noise_v = 0.001;
};
Dataset taxels_between(const std::vector<Extremes>& taxels) {
  Dataset dataset;
  dataset.rows = 1;
  dataset.columns = static_cast<int>(taxels.size());
  Repeat first, second;
  first.steps = second.steps = {{0, 0}};
  for (const Extremes& own : taxels) {
    first.volts.push_back(own.high_v);
    second.volts.push_back(own.low_v);
    dataset.noise_v.push_back(own.noise_v);
    dataset.at_limit.push_back(own.at_limit);
  }
  dataset.sequences = {{"a", {first}}, {"b", {second}}};
  return dataset;
}

std::vector<std::string> states_found(const Health& health) {
  std::vector<std::string> out;
  for (const TaxelHealth& finding : health.findings) out.push_back(std::to_string(finding.taxel) + " " + finding.state);
  return out;
}

// Lines of eight taxels of mean 0 at right angles to each other.
const std::vector<double> kHalf{1, 1, 1, 1, -1, -1, -1, -1}, kQuarter{1, 1, -1, -1, 1, 1, -1, -1},
    kEighth{1, -1, 1, -1, 1, -1, 1, -1};

std::vector<double> mixed(double of_a, const std::vector<double>& a, double of_b, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < a.size(); ++i) out.push_back(of_a * a[i] + of_b * b[i]);
  return out;
}
std::vector<double> two_lines(std::vector<double> first, const std::vector<double>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

}  // namespace

TEST_CASE("health: dead, stuck and saturated taxels are recognised to either side of 50 mV") {
  const Health health = health_of(taxels_between({{0.0, 0.0499},      // dead
                                                  {0.0, 0.0501},      // moves
                                                  {-0.0499, -0.001},  // dead
                                                  {0.02, 0.0501},     // stuck: beyond 50 mV
                                                  {-0.0501, -0.02},   // stuck
                                                  {1.0, 2.0, true}}),
                                  {}, true);
  CHECK(states_found(health) == std::vector<std::string>{"0 dead", "2 dead", "3 stuck", "4 stuck", "5 saturated"});
  CHECK(health.low_v[5] == 1.0);
  CHECK(health.high_v[5] == 2.0);
  CHECK((health.rows == 1 && health.columns == 6 && health.loaded));
  CHECK(health_of(taxels_between({{0.0, 0.06}}), {}, true, {.dead_v = 0.1}).findings.front().state == "dead");
  // Of a run that presses on a part of the array no silent taxel is dead.
  CHECK(health_of(taxels_between({{0.0, 0.01}, {1.0, 2.0, true}}), {}, false).count("dead") == 0);
}

TEST_CASE("health: noise of more than four times the median is reported as noisy") {
  const Dataset data = taxels_between({{0, 1, false, 0.001},
                                       {0, 1, false, 0.001},
                                       {0, 1, false, 0.004},
                                       {0, 1, false, 0.00401},
                                       {0, 1, false, 0.0005}});
  const Health health = health_of(data, {}, true);
  CHECK(health.median_noise_v == 0.001);
  CHECK(states_found(health) == std::vector<std::string>{"3 noisy"});
  CHECK_FALSE(health.findings[0].excluded);
  CHECK_THAT(health.findings[0].reason, Catch::Contains("4.01 mV"));
  CHECK(health_of(data, {}, true, {.noisy_factor = 3.5}).count("noisy") == 2);
}

TEST_CASE("health: states from a fit are listed, with the error of unfit taxels") {
  const Dataset data = taxels_between({{0, 1}, {0, 1}, {0, 1}, {0, 1}});
  SensorModel fit;
  const std::vector<double> ends{0.0, 60.0}, volts{0.0, 2.0};
  const PatternCurve loop(ends, volts, 0.0, 2.0);
  fit.taxels = {by_hand::elam_taxel(loop, loop), by_hand::left_out(TaxelStatus::kUnfit),
                by_hand::left_out(TaxelStatus::kConstant), by_hand::left_out(TaxelStatus::kStuck)};
  fit.taxels[0].status = TaxelStatus::kUnfit;
  fit.taxels[0].fit.mean_error = 0.25;
  CHECK(states_found(health_of(data, fit, false)) ==
        std::vector<std::string>{"0 unfit", "1 unfit", "2 constant", "3 stuck"});
  CHECK_THAT(health_of(data, fit, false).findings[0].reason, Catch::Contains("12.5 %"));
  fit.taxels.pop_back();
  CHECK_THROWS_AS(health_of(data, fit, true), std::invalid_argument);
}

TEST_CASE("swapped lines: must correlate by at least 0.8 with each other's place") {
  // Each line is the other one of before, and a third at right angles to both.
  const auto found = [](double correlation) {
    const double rest = std::sqrt(1.0 - correlation * correlation);
    return swapped_lines(
        2, 8, two_lines(mixed(correlation, kQuarter, rest, kEighth), mixed(correlation, kHalf, rest, kEighth)),
        two_lines(kHalf, kQuarter));
  };
  CHECK(found(0.79).empty());
  REQUIRE(found(0.81).size() == 1);
  const SwappedLines swap = found(0.81)[0];
  CHECK((swap.rows && swap.first == 0 && swap.second == 1));
  CHECK(swap.exchanged == Approx(0.81));
  CHECK(swap.as_is == Approx(0.0).margin(1e-12));
}

TEST_CASE("swapped lines: must fit better by 0.2, in rows and columns, with at least eight taxels") {
  // Two lines that resemble each other by `alike`, exchanged.
  const auto exchanged = [](double alike, bool rows, std::size_t length = 8) {
    std::vector<double> a = kHalf, b = mixed(alike, kHalf, std::sqrt(1.0 - alike * alike), kQuarter);
    a.resize(length);
    b.resize(length);
    std::vector<double> before, now;
    if (rows) return swapped_lines(2, static_cast<int>(length), two_lines(b, a), two_lines(a, b));
    for (std::size_t i = 0; i < length; ++i) {
      before.insert(before.end(), {a[i], b[i]});
      now.insert(now.end(), {b[i], a[i]});
    }
    return swapped_lines(static_cast<int>(length), 2, now, before);
  };
  for (const bool rows : {true, false}) {
    CHECK(exchanged(0.81, rows).empty());
    REQUIRE(exchanged(0.79, rows).size() == 1);
    CHECK(exchanged(0.79, rows)[0].rows == rows);
    CHECK(exchanged(0.79, rows)[0].as_is == Approx(0.79));
    CHECK(exchanged(0.79, rows)[0].exchanged == Approx(1.0));
    CHECK(exchanged(0.0, rows, 7).empty());
  }
}

TEST_CASE("swapped lines: each must be the other's best place, by at least eight finite taxels") {
  const std::vector<double> before = two_lines(two_lines(kHalf, kQuarter), kEighth);
  CHECK(swapped_lines(3, 8, before, before).empty());
  CHECK(swapped_lines(3, 8, two_lines(two_lines(kQuarter, kEighth), kHalf), before).empty());
  const auto last = swapped_lines(3, 8, two_lines(two_lines(kHalf, kEighth), kQuarter), before);
  REQUIRE(last.size() == 1);
  CHECK((last[0].first == 1 && last[0].second == 2));
  // Nine long: one that is not finite leaves eight, two leave seven.
  std::vector<double> a = kHalf, b = kQuarter;
  a.push_back(0.5);
  b.push_back(-0.5);
  std::vector<double> now = two_lines(b, a);
  now[0] = kNan;
  CHECK(swapped_lines(2, 9, now, two_lines(a, b)).size() == 1);
  now[1] = std::numeric_limits<double>::infinity();
  CHECK(swapped_lines(2, 9, now, two_lines(a, b)).empty());
}
