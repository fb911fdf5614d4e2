// Health of taxels and lines at each limit: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "analysis/statistics/numbers/moments.h"
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
  HealthOptions strict;
  strict.dead_v = 0.1;
  CHECK(health_of(taxels_between({{0.0, 0.06}}), {}, true, strict).findings.front().state == "dead");
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
  HealthOptions options;
  options.noisy_factor = 3.5;
  CHECK(health_of(data, {}, true, options).count("noisy") == 2);
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
