// Tables of verdicts and figures that verbs print, and times as people read them.
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/reporting/named_evaluation.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE(
    "table of verdicts: values and limits with three digits in the unit asked for, shares in percent, each rule once") {
  db::VerdictRecord row;
  row.run = 3;
  row.criterion = "worst_taxel_error";
  row.scope = "array";
  row.value = 1.2345;
  row.limit = 3.0;
  row.unit = "psi";
  row.rule = "simple";
  row.verdict = "pass";
  db::VerdictRecord other = row;
  other.criterion = "mismatch";
  other.scope = "40 psi up";
  other.value = std::numeric_limits<double>::quiet_NaN();
  other.limit = 0.06;
  other.unit = "FS";
  other.verdict = "inconclusive";
  db::VerdictRecord guarded = row;
  guarded.rule = "guarded";
  CHECK(verdict_table({row, other, guarded}, "simulated", analysis::PressureUnit::kPsi) ==
        "  run  requirement                scope                       value  tolerance limit  verdict\n"
        "    3  worst taxel's mean error   array                    1.23 psi            3 psi  simulated pass\n"
        "    3  non-uniformity             40 psi increasing    not measured           6 % FS  simulated inconclusive\n"
        "    3  worst taxel's mean error   array                    1.23 psi            3 psi  simulated pass\n"
        "decision rule (ILAC-G8): simple, guarded\n");
  const std::string kpa = verdict_table({row, other}, "hardware", analysis::PressureUnit::kKilopascal);
  CHECK_THAT(kpa, Catch::Contains("8.51 kPa         20.7 kPa  pass") && Catch::Contains("275.8 kPa increasing") &&
                      !Catch::Contains("psi"));
}

TEST_CASE("table of verdicts: one taxel is a taxel") {
  db::VerdictRecord row;
  row.run = 1;
  row.criterion = "unfit_taxels";
  row.scope = "array";
  row.unit = "taxels";
  row.value = 1.0;
  row.limit = 2.0;
  const std::string table = verdict_table({row}, "hardware", analysis::PressureUnit::kPsi);
  CHECK_THAT(table, Catch::Contains(" 1 taxel ") && Catch::Contains(" 2 taxels "));
}

TEST_CASE("table of figures: hysteresis in percent of full scale, the mean absolute error in the unit asked for") {
  NamedEvaluation named;
  named.title = "run 2";
  named.evaluation.raw_distance = 0.105;
  named.evaluation.comp_distance_of_mean = 0.0125;
  named.evaluation.comp_distance = 0.025;
  named.evaluation.comp_distance_observable = 0.0225;
  named.evaluation.worst_taxel_distance = 0.05;
  named.evaluation.worst_taxel_distance_observable = 0.045;
  named.evaluation.mean_error_psi = 0.5231;
  CHECK(
      figures_table({named}, analysis::PressureUnit::kPsi) ==
      "hysteresis, % FS             indication | corrected indication                                 |         mean\n"
      "mean over the levels              array |     array  each taxel (*)   worst taxel  worst taxel*| |error|, psi\n"
      "run 2                             10.50 |      1.25     2.50 (2.25)          5.00          4.50|        0.523\n"
      "array: the outputs (pressures) of all taxels are averaged first; *: without levels flagged unobservable\n");
  const std::string bar = figures_table({named}, analysis::PressureUnit::kBar);
  CHECK_THAT(bar,
             Catch::Contains("| |error|, bar\n") && Catch::Contains("|       0.0361\n") && !Catch::Contains("psi"));
}

TEST_CASE("times in hours, minutes and seconds, rounded to the second") {
  CHECK(clock_text(0.0) == "0:00:00");
  CHECK(clock_text(59.4) == "0:00:59");
  CHECK(clock_text(59.6) == "0:01:00");
  CHECK(clock_text(3599.0) == "0:59:59");
  CHECK(clock_text(3661.0) == "1:01:01");
  CHECK(clock_text(360000.0) == "100:00:00");
}

TEST_CASE("an empty name of the operator is refused") {
  for (const char* nobody : {"", " ", " \t\r\n"}) CHECK_THROWS_AS(check_operator(nobody), Error);
  CHECK_NOTHROW(check_operator(" A. Operator"));
}
