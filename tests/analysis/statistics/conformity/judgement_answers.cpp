// Verdicts row by row, permissible errors at the edges of their spans and shares, and trajectories at their limits.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/conformity/mpe.h"
#include "analysis/statistics/conformity/trajectory.h"
#include "analysis/statistics/conformity/verdict.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;

namespace {

Evaluation evaluated() {
  Evaluation evaluation;
  evaluation.run = 7;
  evaluation.frames = 100;
  evaluation.worst_taxel = 1;
  evaluation.mean_error_psi = 0.25;
  evaluation.worst_taxel_mean_error_psi = 0.75;
  evaluation.comp_distance_of_mean = 0.0125;
  for (const double psi : {20.0, 40.0}) {
    LevelFigures level;
    level.pressure_psi = psi;
    level.comp_std_up = psi / 1000.0;
    level.comp_std_down = psi / 500.0;
    evaluation.levels.push_back(level);
  }
  return evaluation;
}

Limits limits_set() {
  Limits limits;
  limits.rule = DecisionRule::kSimple;
  limits.mean_compensation_error_psi = 0.5;
  limits.worst_taxel_error_psi = 0.5;
  limits.distance_of_mean_fs = 0.0125;
  limits.unfit_taxels = 1;
  limits.mismatch = {{40.0, 0.05}, {30.0, 0.05}};
  limits.mpe = {{0.0, 60.0, 3.0, 0.95}, {20.0, 20.0, 1.0, 0.5}};
  limits.toml = "name = 1";
  limits.sha256 = "abc";
  return limits;
}

struct Row {
  const char *criterion, *scope;
  double value, limit;
  const char *unit, *verdict;
};

void check_rows(const std::vector<db::VerdictRecord>& rows, const std::vector<Row>& expected, const char* rule) {
  REQUIRE(rows.size() == expected.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    INFO(expected[i].criterion << ", " << expected[i].scope);
    CHECK((rows[i].run == 7 && rows[i].criterion == expected[i].criterion && rows[i].scope == expected[i].scope));
    if (std::isnan(expected[i].value))
      CHECK(std::isnan(rows[i].value));
    else
      CHECK(rows[i].value == expected[i].value);
    CHECK(rows[i].limit == expected[i].limit);
    CHECK(rows[i].unit == expected[i].unit);
    CHECK(rows[i].verdict == expected[i].verdict);
    CHECK(rows[i].rule == rule);
    CHECK((rows[i].limits_toml == "name = 1" && rows[i].limits_sha256 == "abc"));
  }
}

}  // namespace

TEST_CASE("verdicts row by row: criterion, scope, value, limit, unit and word of each") {
  const std::vector<MpeFigure> mpe{{"", 2.0, kNan, 8}};
  check_rows(judge(evaluated(), straight_fit(), limits_set(), {}, mpe),
             {{"mean_compensation_error", "array", 0.25, 0.5, "psi", "pass"},
              {"worst_taxel_error", "array", 0.75, 0.5, "psi", "fail"},
              {"distance_of_mean", "array", 0.0125, 0.0125, "FS", "pass"},
              {"unfit_taxels", "array", 1.0, 1.0, "taxels", "pass"},  // the dead one of three
              {"mismatch", "40 psi up", 0.04, 0.05, "FS", "pass"},
              {"mismatch", "40 psi down", 0.08, 0.05, "FS", "fail"},
              {"mismatch", "30 psi up", kNan, 0.05, "FS", "inconclusive"},
              {"mismatch", "30 psi down", kNan, 0.05, "FS", "inconclusive"},
              {"mpe", "0-60 psi 95 %", 2.0, 3.0, "psi", "pass"},
              {"mpe", "20 psi 50 %", kNan, 1.0, "psi", "inconclusive"}},  // no figure of it
             "simple");
  // Nothing was evaluated: nothing passes, but for the count.
  Limits few = limits_set();
  few.mismatch.clear();
  few.mpe.clear();
  Evaluation none = evaluated();
  none.levels.clear();
  none.frames = 0;
  const std::vector<Row> unknown{{"mean_compensation_error", "array", kNan, 0.5, "psi", "inconclusive"},
                                 {"worst_taxel_error", "array", kNan, 0.5, "psi", "inconclusive"},
                                 {"distance_of_mean", "array", kNan, 0.0125, "FS", "inconclusive"},
                                 {"unfit_taxels", "array", 1.0, 1.0, "taxels", "pass"}};
  check_rows(judge(none, straight_fit(), few), unknown, "simple");
  none.frames = 100;
  none.worst_taxel = -1;
  check_rows(judge(none, straight_fit(), few), unknown, "simple");
  none.worst_taxel = 0;
  CHECK(judge(none, straight_fit(), few)[0].verdict == "pass");
}

TEST_CASE("the default rule is four-way where U of the criterion is known, and takes it from the same scope and run") {
  Limits limits = limits_set();
  limits.rule = DecisionRule::kDefault;
  std::vector<JudgedUncertainty> known(2);
  known[0].criterion = "mean_compensation_error";
  known[0].scope = "array";
  known[0].expanded = 0.3;
  known[0].run = 6;
  known[1] = known[0];
  known[1].criterion = "mismatch";
  known[1].scope = "40 psi down";
  known[1].expanded = 0.02;
  known[1].run = 7;
  const auto rows = judge(evaluated(), straight_fit(), limits, known);
  CHECK((rows[0].rule == "four-way" && rows[0].verdict == "conditional pass"));
  CHECK((rows[1].rule == "simple" && rows[1].verdict == "fail"));
  CHECK((rows[4].rule == "simple" && rows[5].rule == "four-way" && rows[5].verdict == "fail"));
  CHECK(find_uncertainty(known, "mismatch", "40 psi down") == &known[1]);
  CHECK(find_uncertainty(known, "mismatch", "40 psi down", 7) == &known[1]);
  CHECK(find_uncertainty(known, "mismatch", "40 psi down", 6) == nullptr);
  CHECK(find_uncertainty(known, "mismatch", "40 psi up") == nullptr);
  CHECK(find_uncertainty(known, "mpe", "40 psi down") == nullptr);
  known[0].expanded = kNan;
  CHECK(judge(evaluated(), straight_fit(), limits, known)[0].rule == "simple");
}

namespace {

// Up and down with the first taxel off by `first` psi at each step, the second by `second`.
Dataset erring(const std::vector<double>& setpoints, const std::vector<double>& first,
               const std::vector<double>& second) {
  std::vector<Sample> steps;
  Readings readings;
  for (std::size_t i = 0; i < setpoints.size(); ++i) {
    steps.push_back({setpoints[i], setpoints[i]});
    readings.first_psi.push_back(setpoints[i] + first[i]);
    readings.second_psi.push_back(setpoints[i] + second[i]);
  }
  return dataset_of({{"loop", {repeat_of(steps, readings)}}});
}

MpeFigure permissible(const Dataset& data, const Limits::Mpe& mpe, const Uncertainty* readings = nullptr) {
  const Limits::Mpe list[] = {mpe};
  return mpe_figures(data, straight_fit(), readings, list, 1).front();
}

}  // namespace

TEST_CASE("mpe by hand: the span's ends are in it, the turn belongs to the way up, repeats and passes are averaged") {
  const Dataset data = erring({0, 20, 40, 60, 40, 20, 0}, {0, 1, -2, -3, 4, 5, 0}, {0, 0, 0, 0, 0, 0, 0});
  const auto worst = [&](double low, double high) { return permissible(data, {low, high, 1.0, 1.0}).value_psi; };
  const auto levels = [&](double low, double high) { return permissible(data, {low, high, 1.0, 1.0}).levels; };
  CHECK(worst(20, 40) == Approx(5.0));
  CHECK(worst(20 - 5e-7, 20 - 5e-7) == Approx(5.0));
  CHECK(worst(20 + 5e-7, 20 + 5e-7) == Approx(5.0));
  CHECK(levels(20, 40) == 4);
  CHECK(levels(20.1, 39.9) == 0);
  CHECK(levels(20.1, 40) == 2);
  CHECK(levels(20, 39.9) == 2);
  CHECK(levels(60, 60) == 1);
  CHECK(worst(60, 60) == Approx(3.0));
  CHECK(levels(0, 60) == 7);  // 0 psi up and down
  // Once up and down, twice at 20 psi upward: 1 and 5 psi off are 3 in the mean.
  const Dataset again = erring({0, 20, 0, 20, 0}, {0, 1, 0, 5, 0}, {0, 0, 0, 0, 0});
  CHECK(permissible(again, {20, 20, 1, 1}).value_psi == Approx(3.0));
  CHECK(permissible(again, {20, 20, 1, 1}).levels == 1);
  CHECK(mpe_figures(data, straight_fit(), nullptr, {}, 1).empty());
}

TEST_CASE("mpe by hand: which share of the taxels, and U between levels that have a budget") {
  SensorModel fit = straight_fit();
  const Dataset data = erring({0, 30, 60, 30, 0}, {0, 1, 0, 1, 0}, {0, 2, 0, 2, 0});
  CHECK(permissible(data, {30, 30, 1, 0.5}).value_psi == Approx(1.0));
  CHECK(permissible(data, {30, 30, 1, 0.51}).value_psi == Approx(2.0));
  CHECK(permissible(data, {30, 30, 1, 1e-6}).value_psi == Approx(1.0));
  // Budgets at 20, 40 and 60 psi: at 30 psi the larger of the neighbours counts, each branch and taxel for itself.
  Uncertainty readings;
  for (const bool up : {true, false})
    for (const auto& [psi, first, second] :
         {std::tuple{20.0, 0.1, 0.5}, std::tuple{40.0, 0.3, 0.2}, std::tuple{60.0, 9.0, 9.0}}) {
      LevelUncertainty level;
      level.pressure_psi = psi;
      level.up = up;
      level.expanded_psi = {up ? first : first + 0.4, second, kNan};
      readings.levels.push_back(level);
    }
  CHECK(permissible(data, {30, 30, 1, 0.5}, &readings).expanded_psi == Approx(0.7));
  CHECK(permissible(data, {30, 30, 1, 1.0}, &readings).expanded_psi == Approx(0.5));
  // A taxel without a budget on one branch is beyond any limit: it counts against the share.
  for (LevelUncertainty& level : readings.levels)
    if (!level.up) level.expanded_psi[1] = kNan;
  CHECK(permissible(data, {30, 30, 1, 0.5}, &readings).expanded_psi == Approx(0.7));
  CHECK(std::isnan(permissible(data, {30, 30, 1, 1.0}, &readings).expanded_psi));
  // Beyond the lowest level with a budget the nearest one counts.
  CHECK(permissible(erring({0, 10, 60}, {0, 1, 0}, {0, 0, 0}), {10, 10, 1, 1}, &readings).expanded_psi == Approx(0.1));
  const std::vector<MpeFigure> figures{{"30 psi 50 %", 1.0, 0.7, 2}, {"a", 1.0, kNan, 2}};
  const auto all = mpe_uncertainties(figures, 12);
  REQUIRE(all.size() == 2);
  CHECK((all[0].criterion == "mpe" && all[0].scope == "30 psi 50 %" && all[0].unit == "psi" && all[0].run == 12));
  CHECK((all[0].expanded == 0.7 && all[0].combined == Approx(0.35) && all[0].factor == 2.0));
  CHECK((std::isinf(all[0].dof) && all[0].missing.empty() && !all[0].basis.empty()));
  CHECK((all[1].missing == "no budget of a reading at the levels judged" && all[1].basis.empty()));
}

namespace {

Dataset along(std::vector<std::vector<double>> paths, double held_s = 2.0) {
  Dataset data;
  for (const std::vector<double>& path : paths) {
    Repeat repeat;
    for (const double psi : path) repeat.steps.push_back({psi, psi, 0.0, held_s});
    data.sequences.push_back({"s", {repeat}});
  }
  return data;
}

}  // namespace

TEST_CASE("trajectory bounds: eight turning points, fewer than a third of them at the ends, are random reversals") {
  const Dataset other = along({{0, 60, 0}});
  const auto kind = [&](const std::vector<double>& path) { return judged_trajectory(along({path}), other).trajectory; };
  // Nine turns, of which 60 is one end: 1 of 9 at an end; then eight and seven.
  const std::vector<double> ten{0, 60, 20, 40, 20, 40, 20, 40, 20, 40, 0}, nine(ten.begin(), ten.end() - 1),
      eight(ten.begin(), ten.end() - 2);
  CHECK(judged_trajectory(along({ten}), other).reversals == 9);
  CHECK(kind(ten) == Trajectory::kRandomReversals);
  CHECK(judged_trajectory(along({nine}), other).reversals == 8);
  CHECK(kind(nine) == Trajectory::kRandomReversals);
  CHECK(judged_trajectory(along({eight}), other).reversals == 7);
  CHECK(kind(eight) == Trajectory::kOther);
  // Of nine turns two or three at an end; within 1 % of the range counts as there.
  CHECK(kind({0, 60, 20, 60, 20, 40, 20, 40, 20, 40, 0}) == Trajectory::kRandomReversals);
  CHECK(kind({0, 60, 20, 60, 20, 60, 20, 40, 20, 40, 0}) == Trajectory::kOther);
  CHECK(kind({0, 60, 20, 60, 20, 59.41, 20, 40, 20, 40, 0}) == Trajectory::kOther);
  CHECK(kind({0, 60, 20, 60, 20, 59.39, 20, 40, 20, 40, 0}) == Trajectory::kRandomReversals);
  CHECK(kind({0, 60, 20, 60, 0.59, 40, 20, 40, 20, 40, 0}) == Trajectory::kOther);
  CHECK(kind({0, 60, 20, 60, 0.61, 40, 20, 40, 20, 40, 0}) == Trajectory::kRandomReversals);
}

TEST_CASE(
    "trajectory by hand: the share of frames on inner branches, of all sequences, and set-points within a millionth") {
  // 6 steps of a full sweep, 2 and 1 of inner ones; then a way of one step in another sequence.
  const JudgedTrajectory judged =
      judged_trajectory(along({{0, 10, 20, 30, 40, 50, 60, 40, 20, 30}, {0, 30}}), along({{0, 60}}));
  CHECK(judged.inner_share == Approx((2.0 + 1.0 + 1.0) / 10.0));
  CHECK(judged.reversals == 2);
  const auto inner = [](double from, double to) {  // beside a sweep from 0 to 60 psi
    return judged_trajectory(along({{0, 60}, {from, to}}), along({{0, 60}})).inner_share;
  };
  CHECK(inner(0.6, 59.41) == 0.0);  // within 2 % of the range's length
  CHECK(inner(0.6, 59.39) == 0.5);
  CHECK(inner(1.19, 60) == 0.0);
  CHECK(inner(1.21, 60) == 0.5);
  CHECK(judged_trajectory({}, along({{0, 60}})).inner_share == 0.0);
  const auto as_fitted = [](double off) {
    return judged_trajectory(along({{0, 20 + off, 60}}), along({{0, 30, 60}, {0, 20, 60}})).trajectory;
  };
  CHECK(as_fitted(9e-7) == Trajectory::kAsFitted);
  CHECK(as_fitted(-9e-7) == Trajectory::kAsFitted);
  CHECK(as_fitted(2e-6) == Trajectory::kOther);
}

TEST_CASE(
    "trajectory: dwells that differ by more than a fifth of the fitted one are told, and what is not known is not") {
  const auto dwells = [](double own_s, double fitted_s) {
    return judged_trajectory(along({{0, 60}}, own_s), along({{0, 60}}, fitted_s));
  };
  CHECK_FALSE(dwells(11.9, 10).other_dwell);
  CHECK(dwells(12.1, 10).other_dwell);
  CHECK_FALSE(dwells(8.1, 10).other_dwell);
  CHECK(dwells(7.9, 10).other_dwell);
  CHECK(dwells(12.1, 10).fitted_dwell_s == 10.0);
  CHECK(std::isnan(dwells(0, 10).dwell_s));
  CHECK_FALSE(dwells(0, 10).other_dwell);
  CHECK(in_words(dwells(12.1, 10)) ==
        "set-points as fitted: 0 turning points, 0 % of the frames on inner branches; dwell 12.1 s (fitted: 10.0 s)");
  CHECK(in_words(dwells(0, 10)) == "set-points as fitted: 0 turning points, 0 % of the frames on inner branches");
  CHECK(std::string(to_string(Trajectory::kOther)) == "other set-points");
  CHECK(std::string(to_string(Trajectory::kRandomReversals)) == "random reversals");
}
