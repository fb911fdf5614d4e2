// Processing of a table's samples before any model: noise, turns and external loop.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/error.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/histories.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/bench/cli/models/known_model.h"

using namespace tactbench::analysis;
using synthetic::table_options;
using tactbench::tests::play_samples;

namespace {

struct AddedNoise {
  double input = 0.0, output = 0.0;
};

// A sensor with play along the turning points.
TableSeries play_series(const std::string& sequence, const std::vector<double>& turns, int steps = 40,
                        AddedNoise noise = {}) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  TableSeries series{sequence, 0, {}, {}};
  for (const auto& sample : play_samples(turns, steps)) {
    series.input.push_back(sample.input + noise.input * normal(random));
    series.output.push_back(sample.output + noise.output * normal(random));
  }
  return series;
}

std::size_t branches_of(const TableSeries& series, double turn = -1.0) {
  return histories_of({series}, "t.csv", table_options(turn)).taxels[0].fit[0].branches.size();
}

const std::vector<double> kTurningPoints = {0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0};

}  // namespace

TEST_CASE("noise estimate: uses the fitted branches, without turning points and without scored data") {
  const std::vector<TableSeries> table = {play_series("fit", kTurningPoints, 40, {0.0, 0.01}),
                                          play_series("score", kTurningPoints, 40, {0.0, 1.0})};
  const auto noise_of = [&](const HistoriesOptions& options) {
    return histories_of(table, "t.csv", options).taxels[0].noise;
  };
  CHECK(noise_of(table_options(-1.0, -1.0, {"fit"})) == Approx(0.01).epsilon(0.15));
  CHECK(noise_of(table_options(-1.0, -1.0, {"score"})) == Approx(1.0).epsilon(0.15));
  CHECK(noise_of(table_options(-1.0, 0.5, {"score"})) == 0.5);
}

TEST_CASE("scored data: change neither the turn size nor the noise of the fitted data") {
  const TableSeries fitted = play_series("fit", kTurningPoints, 40, {0.002, 0.01});
  TableSeries wide = play_series("score", {0, 30, 0, 30, 0}, 400, {0.5, 0.0});
  const HistoriesOptions options = table_options(-1.0, -1.0, {"fit"});
  const TaxelHistories alone = histories_of({fitted}, "t.csv", options).taxels[0];
  const TaxelHistories both = histories_of({fitted, wide}, "t.csv", options).taxels[0];
  CHECK(both.turn == alone.turn);
  CHECK(both.noise == alone.noise);
  CHECK(both.fit[0].branches.size() == alone.fit[0].branches.size());
  CHECK(both.fit[1].branches.size() == 4);  // its own noise does not shred it
}

TEST_CASE("noise estimate: curvature and turning points of a coarse table do not count as noise") {
  TableSeries series{"1", 0, {}, {}};
  for (int cycle = 0; cycle < 5; ++cycle) {
    for (int i = 0; i < 40; ++i) {
      const double x = i < 20 ? -1.0 + i / 10.0 : 3.0 - i / 10.0;
      series.input.push_back(x);
      series.output.push_back(std::tanh(5.0 * x + (i < 20 ? -1.0 : 1.0)));
    }
  }
  CHECK(histories_of({series}, "t.csv").taxels[0].noise < 0.002 * 2.0);
}

TEST_CASE("turning points: are separated from input noise, by default or by a stated turn size") {
  CHECK(branches_of(play_series("1", kTurningPoints, 200, {0.03, 0.0})) == kTurningPoints.size() - 1);
  CHECK(branches_of(play_series("1", kTurningPoints, 200)) == kTurningPoints.size() - 1);
  const TableSeries noisy = play_series("1", {0, 10, 0, 10, 5, 10, 0}, 200, {0.1, 0.0});
  CHECK(branches_of(noisy) == 6);
  const TableSeries wavers = play_series("1", {0, 6, 5.5, 10, 0}, 40);
  CHECK(branches_of(wavers) == 4);
  CHECK(branches_of(wavers, 0.4) == 4);
  CHECK(branches_of(wavers, 0.6) == 2);
}

TEST_CASE("external loop: measured sweeps may miss the extremes, commanded ones may not") {
  const Histories histories = histories_of({play_series("1", {0.2, 10, 0.2, 9.75, 0, 9.75, 0.2}, 100)}, "t.csv");
  const FitData data = fit_data_of(histories.taxels[0], {});
  CHECK(data.no_loop.empty());
  CHECK(data.ascending.x().front() < 0.3);
  CHECK(data.ascending.x().back() > 9.7);
  std::vector<TaxelTable> sequences;
  for (const History& history : data.histories) sequences.push_back({history.x, history.y, history.branches});
  CHECK_THROWS_AS(external_loop(sequences, 1), AnalysisError);
  CHECK(external_loop(sequences, 1, 0.01).left_out > 0.0);
}

TEST_CASE("no external loop: models that do not need one are fitted, ELAM and POLY are refused") {
  const Histories histories = histories_of({play_series("1", {0, 10, 4, 8, 3, 9, 5, 7, 2, 8, 4}, 40)}, "t.csv");
  const FitData data = fit_data_of(histories.taxels[0], {});
  CHECK_FALSE(data.no_loop.empty());
  for (const std::string model : {"gpi", "mpi", "preisach", "monotone"}) {
    INFO(model);
    const ModelFit fit = identify(model, data);
    CHECK(fit.full_scale == Approx(histories.taxels[0].fit[0].y[40] - histories.taxels[0].fit[0].y[0]).epsilon(0.05));
    CHECK(fit.mean_error < (model == "preisach" ? 0.02 : 0.1) * fit.full_scale);
  }
  for (const std::string model : {"elam", "poly"}) {
    INFO(model);
    CHECK(id_of_refusal([&] { return identify(model, data); }) == "TB-ANALYSIS-NO-LOOP");
  }
}

namespace {

std::size_t warnings_of(const TableSeries& series, const HistoriesOptions& options = {}) {
  return histories_of({series}, "t.csv", options).warnings.size();
}

TableSeries with_outputs(TableSeries series, const auto& output_of) {
  for (std::size_t i = 0; i < series.output.size(); ++i)
    series.output[i] = output_of(series.input[i], series.output[i], i);
  return series;
}

}  // namespace

TEST_CASE("table warnings: each doubtful feature is reported once, and a sound recording gives none") {
  const TableSeries sound = play_series("1", kTurningPoints, 40, {0.0, 0.002});
  const double rows = static_cast<double>(sound.input.size());
  const auto [low, high] = std::ranges::minmax(sound.output);
  const double span = high - low;
  CHECK(warnings_of(sound) == 0);
  const auto drifting = [&](double share) {
    return with_outputs(
        sound, [&](double, double y, std::size_t i) { return y + share * span * static_cast<double>(i) / rows; });
  };
  CHECK(warnings_of(drifting(0.01)) == 0);
  CHECK(warnings_of(drifting(0.1)) == 1);
  CHECK(warnings_of(drifting(-0.1)) == 1);
  CHECK(warnings_of(with_outputs(sound, [&](double, double y, std::size_t i) {  // of the gain
          return y * (1.0 + 0.1 * static_cast<double>(i) / rows);
        })) == 1);
  // A connector that was touched; a first loading from the virgin state; loops of both signs, with remanence.
  CHECK(warnings_of(
            with_outputs(sound, [&](double, double y, std::size_t i) { return i > 240 ? y + 0.1 * span : y; })) == 1);
  CHECK(warnings_of(with_outputs(sound, [&](double, double y, std::size_t i) {
          return i < 40 ? y - 0.1 * span * (1.0 - static_cast<double>(i) / 40.0) : y;
        })) == 0);
  CHECK(warnings_of(play_series("1", {0, 10, -10, 10, -10, 4, -4, 7, -7, 10, -10, 6, -2, 8, -10, 10, 0}, 40,
                                {0.0, 0.002})) == 1);  // that it starts in mid-range
  // An output that falls again below the highest input; one that falls all along is another polarity.
  CHECK(warnings_of(with_outputs(
            sound, [](double x, double y, std::size_t) { return x > 7.0 ? y - 3.0 * (x - 7.0) : y; })) == 1);
  CHECK(warnings_of(with_outputs(sound, [](double, double y, std::size_t) { return -y; })) == 0);
  for (const std::size_t from : {30U, 200U}) {  // twelve rows again, at once or far away
    TableSeries twice = sound;
    const auto block = [](std::vector<double>& values, std::size_t first, std::size_t to) {
      const std::vector<double> copy(values.begin() + static_cast<std::ptrdiff_t>(first),
                                     values.begin() + static_cast<std::ptrdiff_t>(first) + 12);
      values.insert(values.begin() + static_cast<std::ptrdiff_t>(to), copy.begin(), copy.end());
    };
    block(twice.input, from, 42);
    block(twice.output, from, 42);
    const HistoriesOptions options = table_options(5.5);
    CHECK(warnings_of(twice, options) == warnings_of(sound, options) + 1);
  }
  CHECK(warnings_of(play_series("1", kTurningPoints, 40)) == 0);  // without noise the same cycle may come again
}

TEST_CASE("table warnings: small slips of the input are reported with a turn size that removes them") {
  const TableSeries clean = play_series("1", kTurningPoints, 40, {0.0, 0.002});
  const std::size_t branches = branches_of(clean);
  for (const std::size_t slips : {4U, 12U}) {  // twelve leave no sweep whole
    TableSeries series = clean;
    for (std::size_t at = 20; at < 20 + 40 * slips; at += 40)
      series.input[at] += series.input[at] > series.input[at - 1] ? -0.4 : 0.4;
    CHECK(branches_of(series) == branches + 2 * slips);
    const std::vector<std::string> warnings = histories_of({series}, "t.csv").warnings;
    const auto told = std::ranges::find_if(
        warnings, [](const std::string& warning) { return warning.find("--turn ") != std::string::npos; });
    REQUIRE(told != warnings.end());
    CHECK_THAT(*told, Catch::Contains(std::to_string(2 * slips) + " of " + std::to_string(branches + 2 * slips)));
    const double turn = std::stod(told->substr(told->find("--turn ") + 7));
    CHECK(branches_of(series, turn) == branches);
    CHECK(warnings_of(series, table_options(turn)) == 0);
  }
  // Small loops on purpose.
  CHECK(warnings_of(play_series("1", {0, 10, 0, 10, 0, 5, 4.2, 5, 4.2, 7, 6.2, 7, 10, 7, 7.8, 7, 5, 5.8, 5, 0, 10, 0},
                                40, {0.0, 0.002})) == 0);
}

TEST_CASE("noise estimate: is at least the rounding of a count, and uses rests of the input") {
  const auto in_counts = [](double count) {
    return [count](double, double y, std::size_t) { return count * std::round(y / count); };
  };
  const TableSeries slow = play_series("1", kTurningPoints, 400);
  for (const double count : {0.01, 0.03}) {
    const double noise = histories_of({with_outputs(slow, in_counts(count))}, "t.csv").taxels[0].noise;
    CHECK(noise >= 0.99 * count / std::sqrt(12.0));
    CHECK(noise < 2.0 * count);
  }
  CHECK(histories_of({slow}, "t.csv").taxels[0].noise < 1e-4);  // no counts
  // A staircase of rests.
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  TableSeries stairs{"1", 0, {}, {}};
  for (const int level : {0, 2, 4, 6, 8, 10, 8, 6, 4, 2, 0}) {
    for (int i = 0; i < 12; ++i) {
      stairs.input.push_back(level);
      stairs.output.push_back(level + 0.01 * normal(random));
    }
  }
  CHECK(histories_of({stairs}, "t.csv").taxels[0].noise == Approx(0.01).epsilon(0.25));
  TableSeries counts = stairs;  // too few values to tell a count by: the last place in which they are written
  for (double& y : counts.output) y = std::round(50.0 * y);
  CHECK(histories_of({counts}, "t.csv").taxels[0].noise >= 0.99 / std::sqrt(12.0));
  for (double& y : stairs.output) y = std::round(y);
  CHECK(histories_of({stairs}, "t.csv").taxels[0].noise == Approx(0.0).margin(1e-9));  // levels are no counts
}

TEST_CASE("external loop: a recording 0, +, -, 0 has one if it ends as it began") {
  const TableSeries loops = play_series("1", {0, 10, -10, 10, -10, 0}, 40);
  CHECK(fit_data_of(histories_of({loops}, "t.csv").taxels[0], {}).no_loop.empty());
  TableSeries once = play_series("1", {-10, 0, 10, -10, 0}, 40);
  once.input.erase(once.input.begin(), once.input.begin() + 40);
  once.output.erase(once.output.begin(), once.output.begin() + 40);
  REQUIRE(once.input.front() == Approx(0.0).margin(1e-9));
  const FitData data = fit_data_of(histories_of({once}, "t.csv").taxels[0], {});
  CHECK(data.no_loop.empty());
  CHECK((data.ascending.x().front() == Approx(-10.0) && data.ascending.x().back() == Approx(10.0)));
  CHECK(identify("poly", data).mean_error < 0.03 * identify("poly", data).full_scale);
  // From another state, as after demagnetising, the two parts are no sweep.
  const TableSeries virgin = with_outputs(once, [](double, double y, std::size_t i) {
    return i < 40 ? y + 3.0 * (1.0 - static_cast<double>(i) / 40.0) : y;
  });
  CHECK_FALSE(fit_data_of(histories_of({virgin}, "t.csv").taxels[0], {}).no_loop.empty());
}

TEST_CASE("table histories: columns that vary only by rounding are refused as constant") {
  TableSeries series = play_series("1", kTurningPoints);
  const auto id = [](const TableSeries& own) { return id_of_refusal([&] { return histories_of({own}, "t.csv"); }); };
  CHECK(id(with_outputs(series, [](double, double y, std::size_t) { return 1.0 + 1e-10 * y; })) ==
        "TB-ANALYSIS-NO-TAXEL");
  for (double& x : series.input) x = 7.0 + 1e-10 * x;
  CHECK(id(series) == "TB-TABLE-CONSTANT");
}

// What is doubtful about a table, at each bound: starts, inner branches, loops, dead bands, jumping inputs, counts.

namespace {

TableSeries doubtful_series(const std::string& name, const std::vector<double>& x, int taxel = 0) {
  TableSeries series{name, taxel, x, {}};
  for (const double input : x) series.output.push_back(2.0 * input);
  return series;
}

Histories doubts_of(const std::vector<TableSeries>& series, double turn = 0.0, double noise = 0.0) {
  return histories_of(series, "t", table_options(turn, noise));
}

std::string about(const Histories& histories, const std::string& words) {
  for (const std::string& line : histories.warnings)
    if (line.find(words) != std::string::npos) return line;
  return {};
}

// Six inner turns, three to each side: nothing to doubt.
const std::vector<double> kSoundWay{0, 100, 20, 80, 30, 70, 40, 60, 50, 100, 0};

}  // namespace

TEST_CASE("table warnings: a start is in mid-range if it is over 1 % of the span, or the turn size, from both ends") {
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

TEST_CASE(
    "table warnings: fewer than three inner branches per direction are reported, those from the ends do not count") {
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

TEST_CASE("table warnings: a missing external loop is reported") {
  const std::vector<double> no_fall{0, 100, 20, 80, 30, 70, 40, 60, 50, 55};
  CHECK_FALSE(about(doubts_of({doubtful_series("a", no_fall)}), "external loop").empty());
  CHECK(about(doubts_of({doubtful_series("a", kSoundWay)}), "external loop").empty());
}

TEST_CASE("table warnings: a dead band above 2 % of the span is reported, with the taxel where it is widest") {
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

TEST_CASE("table histories: tables that are too short, constant or no wider than the turn size are refused") {
  const auto refused = [](const std::vector<TableSeries>& series, double turn = 0.0) {
    return id_of_refusal([&] { return doubts_of(series, turn); });
  };
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}).empty());
  CHECK(refused({doubtful_series("a", {0, 1, 2})}) == "TB-TABLE-SHORT");
  CHECK(refused({doubtful_series("a", {5, 5, 5, 5}, 2)}) == "TB-TABLE-CONSTANT");
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}, 1.99).empty());
  CHECK(refused({doubtful_series("a", {0, 1, 2, 0})}, 2.0) == "TB-TABLE-TURN");
}

TEST_CASE("fit data: without a loop the end outputs are means within 1 % of the lowest and highest input") {
  TableSeries series{"a", 0, {0, 1, 1.5, 50, 98.5, 99, 100}, {1.0, 2.0, 4.0, 5.0, 6.0, 8.0, 9.0}};
  const FitData data = fit_data_of(doubts_of({series}).taxels[0], {});
  CHECK_FALSE(data.no_loop.empty());
  CHECK(data.ascending.y().front() == Approx(1.5));
  CHECK(data.ascending.y().back() == Approx(8.5));
  CHECK(data.ascending.x().front() == 0.0);
  CHECK(data.ascending.x().back() == 100.0);
}

TEST_CASE("turn size: is seven times the input noise if fifty samples show it, at least 0.1 % of the span") {
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

TEST_CASE("turn size: a stated value, also 0, applies to sequences that are only scored, too") {
  TableSeries even{"even", 0, {}, {}}, noisy{"noisy", 0, {}, {}};
  for (int i = 0; i <= 200; ++i) {
    const double ramp = 100.0 - std::abs(100 - i);
    even.input.push_back(ramp);
    noisy.input.push_back(ramp + (i == 0 || i == 200 ? 0.0 : i % 2 == 0 ? 1.5 : -1.5));
  }
  even.output = even.input;
  noisy.output = noisy.input;
  const auto branches_with = [&](double turn) {
    return histories_of({even, noisy}, "t", table_options(turn, -1.0, {"even"})).taxels[0].score[1].branches.size();
  };
  CHECK(branches_with(0.0) > 100);
  CHECK(branches_with(0.5) > 100);
  CHECK(branches_with(5.0) == 2);
  CHECK(branches_with(-1.0) == 2);  // the sequence's own noise
}

TEST_CASE("table warnings: inputs that jump are reported with their noise, and get the smallest turn size") {
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

TEST_CASE("noise of counts: is the rounding to a count if twenty values show it, else to the last decimal place") {
  const auto noise_with = [](std::size_t equal, std::size_t steps) {
    // `steps` of 0.5 in a row, then so many equal ones; the way back is one step.
    TableSeries series{"a", 0, {0.0}, {0.0}};
    for (std::size_t i = 0; i < steps + equal; ++i) {
      series.input.push_back(series.input.back() + 1.0);
      series.output.push_back(series.output.back() + (i < steps ? 0.5 : 0.0));
    }
    return histories_of({series}, "t", table_options(0.0)).taxels[0].noise;
  };
  // Outputs that never change are not counts: in a fitted sequence, next to one that is not fitted.
  const HistoriesOptions still = table_options(0.0, -1.0, {"a"});
  const TableSeries constant{"a", 0, {0, 1, 2, 1, 0}, {3, 3, 3, 3, 3}}, other{"b", 0, {0, 1, 2, 1, 0}, {0, 9, 5, 7, 1}};
  CHECK(histories_of({constant, other}, "t", still).taxels[0].noise == 0.0);
  CHECK(noise_with(61, 60) == Approx(0.5 / std::sqrt(12.0)));
  CHECK(noise_with(11, 10) == Approx(0.1 / std::sqrt(12.0)));
  // Half of the neighbours differ: the median of twenty differences is one of 0.5 over sqrt 2.
  CHECK(noise_with(10, 10) == Approx(0.5 / std::sqrt(2.0) / 0.67449));
}
