// Health of taxels and lines at each limit, and drift at its own: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "analysis/models/monotone.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/sensor/drift.h"
#include "analysis/statistics/sensor/health.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench::analysis;

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

TEST_CASE("health by hand: dead, stuck and saturated to each side of 50 mV") {
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
  HealthOptions strict;
  strict.dead_v = 0.1;
  CHECK(health_of(taxels_between({{0.0, 0.06}}), {}, true, strict).findings.front().state == "dead");
  // Of a run that presses on a part of the array no silent taxel is dead.
  CHECK(health_of(taxels_between({{0.0, 0.01}, {1.0, 2.0, true}}), {}, false).count("dead") == 0);
}

TEST_CASE("health by hand: noise above four times the median taxel's, none without noise") {
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
  HealthOptions options;
  options.noisy_factor = 3.5;
  CHECK(health_of(data, {}, true, options).count("noisy") == 2);
}

TEST_CASE("health by hand: what a fit says of its taxels, with the error of those that do not fit") {
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

TEST_CASE("swapped rows and columns are found, a changed gain and noise are not") {
  const int rows = 16, columns = 12;
  std::mt19937 random(11);
  std::vector<double> before;
  for (int i = 0; i < rows * columns; ++i) before.push_back(0.5 + static_cast<double>(random()) / 4294967296.0);
  const auto at = [&](std::vector<double>& frame, int row, int column) -> double& {
    return frame[static_cast<std::size_t>(row * columns + column)];
  };
  std::vector<double> now = before;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] *= 1.2 + 0.01 * std::sin(static_cast<double>(i));
  CHECK(swapped_lines(rows, columns, now, before).empty());
  for (int column = 0; column < columns; ++column) std::swap(at(now, 1, column), at(now, 4, column));
  const auto swaps = swapped_lines(rows, columns, now, before);
  REQUIRE(swaps.size() == 1);
  CHECK(swaps[0].rows);
  CHECK(swaps[0].first == 1);
  CHECK(swaps[0].second == 4);
  CHECK(swaps[0].exchanged > 0.95);
  // A taxel that stands still hides the exchange, one that is known to do so does not.
  at(now, 4, 7) = 40.0;
  CHECK(swapped_lines(rows, columns, now, before).empty());
  at(now, 4, 7) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(swapped_lines(rows, columns, now, before).size() == 1);
  CHECK(swapped_lines(rows, columns, now, before)[0].exchanged > 0.95);
  for (int column = 0; column < 5; ++column) at(now, 4, column) = std::numeric_limits<double>::quiet_NaN();
  CHECK(swapped_lines(rows, columns, now, before).empty());  // six are left: too few to tell
  now = before;
  for (int row = 0; row < rows; ++row) std::swap(at(now, row, 0), at(now, row, 3));
  const auto columns_swapped = swapped_lines(rows, columns, now, before);
  REQUIRE(columns_swapped.size() == 1);
  CHECK_FALSE(columns_swapped[0].rows);
  CHECK(columns_swapped[0].second == 3);
  CHECK(swapped_lines(2, 3, {1, 2, 3, 3, 2, 1}, {3, 2, 1, 1, 2, 3}).empty());  // too short to tell
}

TEST_CASE("swapped lines: they fit each other's place by 0.8 at least") {
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

TEST_CASE("swapped lines: they fit better by 0.2, in rows and in columns, from eight taxels on") {
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

TEST_CASE(
    "swapped lines: each is the other's best place, three that went round are no pair, eight that tell are enough") {
  const std::vector<double> before = two_lines(two_lines(kHalf, kQuarter), kEighth);
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

namespace {

ModelTaxel straight_unit(int number) {
  const std::vector<double> ends{0.0, 10.0};
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, ends, 0.0, 10.0));
  taxel.fit.full_scale = 10.0;
  taxel.ascending = taxel.descending = PatternCurve(ends, ends, 0.0, 10.0);
  return taxel;
}

Histories read_as(const std::vector<std::vector<double>>& inputs, const std::vector<std::vector<double>>& outputs) {
  Histories histories;
  histories.source = "run 5";
  histories.content_sha256 = "0123456789abcdef";
  TaxelHistories taxel;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    History history;
    history.name = "h" + std::to_string(i);
    history.x = inputs[i];
    history.y = outputs[i];
    history.branches = branches_along(history.x);
    taxel.score.push_back(history);
  }
  histories.taxels = {taxel};
  return histories;
}

SensorModel one_unit() {
  SensorModel document;
  document.model = "monotone";
  document.input_unit = "psi";
  document.output_unit = "V";
  document.rows = document.columns = 1;
  document.taxels = {straight_unit(0)};
  return document;
}

}  // namespace

TEST_CASE("drift by hand: two samples leave no degree of freedom, and one counts") {
  // Inputs too near to each other for a gain: residuals of -0.5 and 0.5 about the mean; 0.5 over one, of two.
  const TaxelDrift drift = drift_of(one_unit(), read_as({{3, 3.5}}, {{7, 8.5}})).taxels.front();
  CHECK(drift.gain == 1.0);
  CHECK(drift.zero == Approx(4.5));
  CHECK(drift.zero_u == Approx(std::sqrt(0.5 / 2)));
  CHECK(drift.as_is == Approx((4.0 + 5.0) / 2 / 10));
  CHECK(drift.zeroed == Approx(0.05));
}

TEST_CASE("an adjusted model names its parent and the data, and its loop moves with it") {
  const SensorModel document = one_unit();
  const Histories data = read_as({{0, 10}}, {{1, 21}});
  const Drift drift = drift_of(document, data);
  const SensorModel both = adjusted(document, drift, data, true);
  CHECK_THAT(both.adjustment, Catch::Contains("0123456789ab"));
  CHECK(both.parent_sha256 == sha256_of(document));
  CHECK(both.taxels[0].y0() == Approx(1.0));
  CHECK(both.taxels[0].yu() == Approx(21.0));
  const SensorModel zero = adjusted(document, drift, data, false);
  CHECK_THAT(zero.adjustment, Catch::Contains("0123456789ab"));
  CHECK(zero.taxels[0].y0() == Approx(6.0));
  CHECK(zero.taxels[0].yu() == Approx(16.0));
  // Adjusted once more from there, by the same data: the zero of 1, of the model as it was fitted.
  const SensorModel again = adjusted(zero, drift_of(zero, data), data, true);
  CHECK(again.taxels[0].y0() == Approx(1.0));
  CHECK(again.taxels[0].yu() == Approx(21.0));
}
