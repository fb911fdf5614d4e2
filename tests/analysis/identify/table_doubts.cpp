// What is doubtful about a table, at each bound: starts, inner branches, loops, dead bands, jumping inputs, counts.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/histories.h"
#include "tests/analysis/identify/refusals.h"

using namespace tactbench::analysis;

namespace {

TableSeries doubtful_series(const std::string& name, const std::vector<double>& x, int taxel = 0) {
  TableSeries series{name, taxel, x, {}};
  for (const double input : x) series.output.push_back(2.0 * input);
  return series;
}

Histories doubts_of(const std::vector<TableSeries>& series, double turn = 0.0, double noise = 0.0) {
  HistoriesOptions options;
  options.turn = turn;
  options.noise = noise;
  return histories_of(series, "t", options);
}

std::string about(const Histories& histories, const std::string& words) {
  for (const std::string& line : histories.warnings)
    if (line.find(words) != std::string::npos) return line;
  return {};
}

// Six inner turns, three to each side: nothing to doubt.
const std::vector<double> kSoundWay{0, 100, 20, 80, 30, 70, 40, 60, 50, 100, 0};

}  // namespace

TEST_CASE("doubts: a start is in mid-range beyond 1 % of the span from both ends, or beyond the turn") {
  const auto start = [](double first, double turn = 0.0) {
    std::vector<double> way = kSoundWay;
    way.insert(way.begin(), {first});
    return about(doubts_of({doubtful_series("a", way)}, turn), "in mid-range");
  };
  CHECK(start(0.99).empty());
  CHECK_THAT(start(1.01), Catch::Contains("1.01"));
  CHECK(start(99.01).empty());
  CHECK_FALSE(start(98.99).empty());
  CHECK(start(4.9, 5.0).empty());
  CHECK_FALSE(start(5.1, 5.0).empty());
}

TEST_CASE("doubts: three inner branches of each direction are needed, those that begin at the ends do not count") {
  const auto inner = [](const std::vector<double>& way) {
    return about(doubts_of({doubtful_series("a", way)}), "few reversals");
  };
  CHECK(inner(kSoundWay).empty());
  CHECK_THAT(inner({0, 100, 20, 80, 30, 70, 40, 100, 0}), Catch::Contains("2 branches") && Catch::Contains("3 rise"));
  CHECK_THAT(inner({0, 100, 20, 80, 30, 70, 0, 100, 0}), Catch::Contains("2 rise"));
  CHECK_THAT(inner({0, 100, 20, 100, 0}), Catch::Contains("1 rise"));
  CHECK_THAT(inner({0, 100, 20, 80, 0}), Catch::Contains("1 rise"));
  CHECK_THAT(inner({0, 100, 0.9, 99.1, 0.9, 99.1, 0.9, 99.1, 0}), Catch::Contains("0 branches"));
}

TEST_CASE("doubts: no external loop, and one that does not reach the extremes") {
  const std::vector<double> no_fall{0, 100, 20, 80, 30, 70, 40, 60, 50, 55};
  CHECK_FALSE(about(doubts_of({doubtful_series("a", no_fall)}), "external loop").empty());
  CHECK(about(doubts_of({doubtful_series("a", kSoundWay)}), "external loop").empty());
}

TEST_CASE("doubts: a dead band of more than 2 % of the span, of the taxel where it is widest") {
  // Six noises of an output that spans 200.
  const auto band = [](double noise) {
    return about(doubts_of({doubtful_series("a", kSoundWay)}, 0.0, noise), "dead band");
  };
  CHECK(band(0.66).empty());
  CHECK_THAT(band(0.67), Catch::Contains("2.01 %"));
  TableSeries narrow = doubtful_series("a", kSoundWay, 3);
  for (double& y : narrow.output) y *= 0.5;
  CHECK_THAT(about(doubts_of({doubtful_series("a", kSoundWay, 1), narrow}, 0.0, 0.67), "dead band"),
             Catch::Contains("4.02 %") && Catch::Contains("taxel 3"));
}

TEST_CASE("tables that are too short, constant, or whose turn is as wide as the inputs are refused") {
  const auto refused = [](const std::vector<TableSeries>& series, double turn = 0.0) {
    return id_of_refusal([&] { return doubts_of(series, turn); });
  };
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}).empty());
  CHECK(refused({doubtful_series("a", {0, 1, 2})}) == "TB-TABLE-SHORT");
  CHECK(refused({doubtful_series("a", {5, 5, 5, 5}, 2)}) == "TB-TABLE-CONSTANT");
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}, 1.99).empty());
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}, 2.0) == "TB-TABLE-TURN");
}

TEST_CASE("without a loop the outputs span from the mean within 1 % of the lowest input to that of the highest") {
  TableSeries series{"a", 0, {0, 1, 1.5, 50, 98.5, 99, 100}, {1.0, 2.0, 4.0, 5.0, 6.0, 8.0, 9.0}};
  HistoriesOptions options;
  options.turn = 0.0;
  options.noise = 0.0;
  const Histories histories = histories_of({series}, "t", options);
  const FitData data = fit_data_of(histories.taxels[0], {});
  CHECK_FALSE(data.no_loop.empty());
  CHECK(data.ascending.y().front() == Approx(1.5));
  CHECK(data.ascending.y().back() == Approx(8.5));
  CHECK(data.ascending.x().front() == 0.0);
  CHECK(data.ascending.x().back() == 100.0);
}

TEST_CASE("turns of a table by hand: seven noises of the inputs where fifty tell them, at least 0.1 % of the span") {
  // A ramp up and down with a step back of `back` in the middle of the way up.
  const auto turn_of = [](std::size_t samples, double wave) {
    TableSeries series{"a", 0, {}, {}};
    for (std::size_t i = 0; i < samples; ++i) {
      const double at = static_cast<double>(i) / static_cast<double>(samples - 1);
      const double ramp = 100.0 * (at < 0.5 ? 2 * at : 2 - 2 * at);
      series.input.push_back(ramp + (i == 0 || i + 1 == samples ? 0.0 : i % 2 == 0 ? wave : -wave));
      series.output.push_back(ramp);
    }
    return histories_of({series}, "t", {}).taxels[0].turn;
  };
  CHECK(turn_of(201, 0.0) == Approx(0.1));
  CHECK(turn_of(49, 0.5) == Approx(0.1).epsilon(0.01));  // too few to tell
  CHECK(turn_of(51, 0.5) > 1.0);
  // Of alternate samples the least of the differences' orders is about 1.41 times the wave over 0.67449.
  CHECK(turn_of(401, 0.5) == Approx(7.0 * 0.5 * std::sqrt(2.0) / 0.67449).epsilon(0.3));
  CHECK(turn_of(401, 20.0) < 1.0);  // more than a quarter of the span: such inputs jump
}

TEST_CASE("turns of a table by hand: a stated size, and 0 is one, is that of sequences that are only scored, too") {
  TableSeries even{"even", 0, {}, {}}, noisy{"noisy", 0, {}, {}};
  for (int i = 0; i <= 200; ++i) {
    const double ramp = 100.0 - std::abs(100 - i);
    even.input.push_back(ramp);
    noisy.input.push_back(ramp + (i == 0 || i == 200 ? 0.0 : i % 2 == 0 ? 1.5 : -1.5));
  }
  even.output = even.input;
  noisy.output = noisy.input;
  const auto branches_with = [&](double turn) {
    HistoriesOptions options;
    options.turn = turn;
    options.fitted = {"even"};
    return histories_of({even, noisy}, "t", options).taxels[0].score[1].branches.size();
  };
  CHECK(branches_with(0.0) > 100);
  CHECK(branches_with(0.5) > 100);
  CHECK(branches_with(5.0) == 2);
  CHECK(branches_with(-1.0) == 2);  // the sequence's own noise
}

TEST_CASE("inputs that jump are told with their noise, and their turns are the least") {
  // 0 10 0 10 ...: the first differences are 10 over sqrt 2, less than those of any other order; 73.4 are seven noises.
  TableSeries series{"a", 0, {}, {}};
  for (int i = 0; i < 60; ++i) {
    series.input.push_back(i % 2 == 0 ? 0.0 : 10.0);
    series.output.push_back(series.input.back());
  }
  const Histories found = histories_of({series}, "t", {});
  CHECK_THAT(found.warnings.front(), Catch::Contains("73.4") && Catch::Contains("--turn"));
  CHECK(found.taxels[0].turn == Approx(0.01));
}

TEST_CASE("noise of counts by hand: rounding's to a count where twenty tell it, else to the last decimal place") {
  const auto noise_with = [](std::size_t equal, std::size_t steps) {
    // `steps` of 0.5 in a row, then so many equal ones; the way back is one step.
    TableSeries series{"a", 0, {0.0}, {0.0}};
    for (std::size_t i = 0; i < steps + equal; ++i) {
      series.input.push_back(series.input.back() + 1.0);
      series.output.push_back(series.output.back() + (i < steps ? 0.5 : 0.0));
    }
    HistoriesOptions options;
    options.turn = 0.0;
    return histories_of({series}, "t", options).taxels[0].noise;
  };
  // Outputs that never change are no counts: of a sequence that is fitted, beside one that is not.
  HistoriesOptions still;
  still.turn = 0.0;
  still.fitted = {"a"};
  const TableSeries constant{"a", 0, {0, 1, 2, 1, 0}, {3, 3, 3, 3, 3}}, other{"b", 0, {0, 1, 2, 1, 0}, {0, 9, 5, 7, 1}};
  CHECK(histories_of({constant, other}, "t", still).taxels[0].noise == 0.0);
  CHECK(noise_with(61, 60) == Approx(0.5 / std::sqrt(12.0)));
  CHECK(noise_with(11, 10) == Approx(0.1 / std::sqrt(12.0)));
  // Half of the neighbours differ: the median of twenty differences is one of 0.5 over sqrt 2.
  CHECK(noise_with(10, 10) == Approx(0.5 / std::sqrt(2.0) / 0.67449));
}
