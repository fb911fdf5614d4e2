// Verdicts row by row.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/judgement.h"
#include "analysis/judgement/mpe.h"
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

TEST_CASE("a level is met by the nearest one measured within 0.01 psi, and is called as that one") {
  Evaluation evaluation = evaluated();
  evaluation.levels[0].pressure_psi = 100.0 / 6.894757293168361;  // 14.503774 psi; the other is 40
  Limits limits = limits_set();
  limits.mpe.clear();
  for (const double typed : {14.5038, 14.5, 14.51, 14.50377}) {
    CAPTURE(typed);
    limits.mismatch = {{typed, 0.05}};
    const auto rows = judge(evaluation, straight_fit(), limits);
    CHECK((rows[4].value == 0.02 && rows[4].verdict == "pass" && rows[4].scope == "14.5038 psi up"));
  }
  for (const double other : {14.49, 14.515, 15.0}) {
    CAPTURE(other);
    limits.mismatch = {{other, 0.05}};
    CHECK(judge(evaluation, straight_fit(), limits)[4].verdict == "inconclusive");
  }
  constexpr double kKilopascals = 6.894757293168361;
  for (const auto& [level_kpa, typed] :
       {std::pair(40.0, 5.8015), std::pair(40.0, 5.80), std::pair(120.0, 17.4045), std::pair(20.0, 2.9008)}) {
    CAPTURE(typed);
    evaluation.levels[0].pressure_psi = level_kpa / kKilopascals;
    limits.mismatch = {{typed, 0.05}};
    CHECK(judge(evaluation, straight_fit(), limits)[4].verdict == "pass");
  }
  evaluation.levels[0].pressure_psi = 100.0 / kKilopascals;
  evaluation.levels[1].pressure_psi = 14.498;  // steps finer than that: the nearest, not the first
  limits.mismatch = {{14.497, 0.05}};
  CHECK(judge(evaluation, straight_fit(), limits)[4].value == 0.04);
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
