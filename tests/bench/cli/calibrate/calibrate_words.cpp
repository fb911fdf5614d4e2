// What `calibrate` says of a verdict: the large word, its reason in one line, the bad taxels.
#include "bench/cli/calibrate/calibrate_words.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/cli/calibrate/calibration.h"
#include "bench/cli/calibrate/large_word.h"
#include "bench/cli/judgement_words.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

db::VerdictRecord row(const char* criterion, const char* scope, double value, double limit, const char* unit,
                      const char* verdict) {
  db::VerdictRecord record;
  record.run = 2;
  record.model_run = 1;
  record.criterion = criterion;
  record.scope = scope;
  record.value = value;
  record.limit = limit;
  record.unit = unit;
  record.verdict = verdict;
  return record;
}

Judgement judgement_of(std::vector<db::VerdictRecord> rows) {
  Judgement judgement;
  judgement.verdicts = std::move(rows);
  return judgement;
}

const db::VerdictRecord kGood = row("distance_of_mean", "array", 0.001, 0.015, "FS", "pass");
const db::VerdictRecord kDead = row("unfit_taxels", "array", 1, 0, "taxels", "fail");
const db::VerdictRecord kWorst = row("worst_taxel_error", "array", 3.4, 3, "psi", "fail");
const db::VerdictRecord kUneven = row("mismatch", "40 psi up", 0.06, 0.05, "FS", "fail");
const db::VerdictRecord kAbsent = row("mismatch", "10 psi up", std::nan(""), 0.05, "FS", "inconclusive");

// 2 x 3 taxels, of which numbers 1 and 5 have no model; the worst one on the held-out run is number 3.
JudgedFit small_fit() {
  JudgedFit fit;
  fit.model.rows = 2;
  fit.model.columns = 3;
  for (int taxel = 0; taxel < 6; ++taxel) {
    analysis::ModelTaxel& own = fit.model.taxels.emplace_back();
    own.taxel = taxel;
    own.status = taxel == 1   ? analysis::TaxelStatus::kDead
                 : taxel == 5 ? analysis::TaxelStatus::kSaturated
                              : analysis::TaxelStatus::kFitted;
  }
  NamedEvaluation own, held_out;
  own.evaluation.worst_taxel = 0;
  held_out.evaluation.worst_taxel = 3;
  held_out.evaluation.worst_taxel_mean_error_psi = 3.4;
  fit.evaluations = {own, held_out};
  return fit;
}

std::string large_of(std::vector<db::VerdictRecord> rows) { return large_verdict(judgement_of(std::move(rows))); }

}  // namespace

TEST_CASE("calibrate words: a large word, its margin before each line") {
  CHECK(large_word("fail", "SIMULATED  ") ==
        "SIMULATED  #####  ###  ### #\nSIMULATED  #     #   #  #  #\nSIMULATED  ####  #####  #  #\n"
        "SIMULATED  #     #   #  #  #\nSIMULATED  #     #   # ### #####\n");
  const std::string longest = large_word("INCONCLUSIVE", "SIMULATED  ");
  for (std::size_t from = 0, end = 0; from < longest.size(); from = end + 1) {
    end = longest.find('\n', from);
    CHECK(end - from <= 80);  // of a plain terminal
  }
  CHECK_NOTHROW(large_word("PASS", ""));
  CHECK_THROWS_WITH(large_word("YES", ""), "no large letter for 'Y'");
}

TEST_CASE("calibrate words: the large word is as the exit code, and there is none without a statement") {
  CHECK(large_of({kGood}) == "PASS");
  CHECK(large_of({kGood, row("mismatch", "8 psi up", 1, 1, "FS", "conditional pass")}) == "PASS");
  CHECK(large_of({kGood, row("mismatch", "8 psi up", 1, 1, "FS", "conditional fail")}) == "INCONCLUSIVE");
  CHECK(large_of({kGood, kAbsent}) == "INCONCLUSIVE");
  CHECK(large_of({kGood, kAbsent, kDead}) == "FAIL");
  CHECK(large_of({row("mismatch", "8 psi up", 1, 1, "FS", "report only")}).empty());
  Judgement own = judgement_of({kGood});
  own.notes.not_judged = "no independent data";
  CHECK(large_verdict(own) == "INCONCLUSIVE");
  CHECK(reason_text(own, "x", 2) == "not judged: no independent data");
}

TEST_CASE("calibrate words: the reason names what decided, with value and limit") {
  const auto reason = [](std::vector<db::VerdictRecord> rows) {
    return reason_text(judgement_of(std::move(rows)), "gripper", 2);
  };
  CHECK(reason({kGood, kGood}) == "all 2 requirements of 'gripper' pass on held-out run 2");
  CHECK(reason({kGood, kDead, kAbsent}) == "taxels not modelled: 1 (tolerance limit 0), on held-out run 2");
  CHECK(reason({kDead, kWorst, kUneven}) ==
        "taxels not modelled: 1 (tolerance limit 0); worst taxel's mean error: 3.4 psi (tolerance limit 3 psi); and 1 "
        "more, "
        "on held-out run 2");
  CHECK(reason({kUneven}) == "non-uniformity at 40 psi increasing: 6 % FS (tolerance limit 5 % FS), on held-out run 2");
  CHECK(reason({kAbsent}) ==
        "non-uniformity at 10 psi increasing: not measured (tolerance limit 5 % FS), on held-out run 2");
  CHECK(reason({kGood, row("mean_compensation_error", "array", 0.903, 1, "psi", "conditional pass")}) ==
        "mean absolute error: 0.903 psi (tolerance limit 1 psi), within the uncertainty below the limit, on held-out "
        "run 2");
}

TEST_CASE("calibrate words: bad taxels by row and column, the worst one only where its criterion fails") {
  const auto bad = [](std::vector<db::VerdictRecord> rows) {
    std::string text;
    for (const BadTaxel& taxel : bad_taxels(small_fit(), judgement_of(std::move(rows))))
      text += std::to_string(taxel.row) + "," + std::to_string(taxel.column) + " " + taxel.why + "; ";
    return text;
  };
  CHECK(bad({kDead}) == "0,1 dead; 1,2 saturated; ");
  CHECK(bad({kDead, kWorst}) == "0,1 dead; 1,2 saturated; 1,0 mean |error| 3.40 psi, the largest; ");
  JudgedFit first = small_fit();
  first.evaluations.back().evaluation.worst_taxel = 0;
  const std::vector<BadTaxel> with_first = bad_taxels(first, judgement_of({kWorst}));
  REQUIRE(with_first.size() == 3);
  CHECK((with_first.back().row == 0 && with_first.back().column == 0));
  first.evaluations.back().evaluation.worst_taxel = -1;  // none
  CHECK(bad_taxels(first, judgement_of({kWorst})).size() == 2);
}

TEST_CASE("calibrate words: the words that carry on leave out what the profile and the defaults give") {
  const tests::TemporaryFolder folder;
  tests::write_file(folder.path("tactbench.toml"), "bench = \"rig.toml\"\noperator = \"me\"\n");
  Session session;
  session.profile = ProfileOptions(folder.path("tactbench.toml"));
  CalibrateOptions options;
  options.serial = "MY-1";
  options.bench = "rig.toml";
  options.operator_name = "me";
  CHECK(calibrate_again(options, session, 0, 0) == "tactbench calibrate MY-1");
  CHECK(calibrate_again(options, session, 3, 4) == "tactbench calibrate MY-1 --run 3 --held-out 4");
  options.operator_name = "A. O'Neil";
  options.recipes = {"descending", "ascending"};
  options.set = {"recipe.repeats=1"};
  options.seeds.seed = 7;
  session.db = "b.db";
  CHECK(calibrate_again(options, session, 3, 0) ==
        "tactbench calibrate MY-1 --db b.db --operator 'A. O'\\''Neil' --recipe descending --recipe ascending --set "
        "recipe.repeats=1 --seed 7 --run 3");
}

TEST_CASE("calibrate words: every option that is not as standard is among the words that carry on") {
  const tests::TemporaryFolder folder;
  Session session;
  session.profile = ProfileOptions(folder.path("none.toml"));
  CalibrateOptions options;
  options.serial = "";
  CHECK(calibrate_again(options, session, 0, 0) == "tactbench calibrate '' --bench '' --operator ''");
  options.serial = "a b";
  options.bench = "b.toml";
  options.operator_name = "me";
  options.held_out_recipes = {"noise", "a&b"};
  options.limits = "own.toml";
  options.lab = "lab.toml";
  options.model = "elam";
  options.metadata.lot = "A7";
  options.metadata.order = "55/26";
  options.metadata.pairs = {"film=B12", "x=y"};
  options.seeds.sensor_seed = 0;
  CHECK(
      calibrate_again(options, session, 0, 4) ==
      "tactbench calibrate 'a b' --bench b.toml --operator me --held-out-recipe noise --held-out-recipe 'a&b' --limits "
      "own.toml --lab lab.toml --model elam --lot A7 --order 55/26 --meta film=B12 --meta x=y --sensor-seed 0 "
      "--held-out 4");
  CalibrateOptions plain;
  plain.serial = "aZ09_-./:=,+%@";  // no quotes for any of these
  plain.bench = "b";
  plain.operator_name = "me";
  CHECK(calibrate_again(plain, session, 0, 0) == "tactbench calibrate aZ09_-./:=,+%@ --bench b --operator me");
}

TEST_CASE("calibrate words: the page of a verdict, and the same as JSON") {
  CalibrationResult result;
  result.sensor = "MY-1";
  result.origin = "simulated";
  result.limits = "gripper";
  result.registered = true;
  result.run = 1;
  result.held_out = 2;
  result.fit = small_fit();
  result.fit.model.model = "elam";
  result.fit.model.run = 1;
  result.fit.evaluations.back().evaluation.run = 2;
  result.fit.evaluations.back().evaluation.mean_error_psi = 0.9031;
  result.judgement = judgement_of({kGood, kDead});
  result.judgement.notes.remarks = {"run 7 is void"};
  result.report_number = "7-a";
  result.report_path = "reports/run-1.html";
  CHECK(verdict_page(result) == "\n" + large_word("FAIL", "SIMULATED  ") +
                                    "\nsensor MY-1: simulated fail: taxels not modelled: 1 (tolerance limit 0), on "
                                    "held-out run 2\nbad taxels: row 0, column 1 (dead); row 1, column 2 (saturated)\n"
                                    "note: run 7 is void\n");
  CHECK(fit_line(result) ==
        "elam on run 1: 4 of 6 taxels fitted; on run 2 mean |error| 0.903 psi, worst taxel 3.40 psi");
  const auto json = calibration_json(result);
  CHECK(json.at("sensor") == "MY-1");
  CHECK(json.at("registered") == true);
  CHECK((json.at("run") == 1 && json.at("held_out") == 2));
  CHECK(json.at("verdict") == "fail");
  CHECK(json.at("shown") == "simulated fail");
  CHECK(json.at("bad_taxels").size() == 2);
  CHECK(json.at("evaluations").size() == 2);
  CHECK(json.at("verdicts").size() == 2);
  CHECK(json.at("report").at("number") == "7-a");
  result.origin = "hardware";
  result.judgement = judgement_of({row("mismatch", "8 psi up", 1, 1, "FS", "report only")});
  for (int taxel = 6; taxel < 18; ++taxel) {
    analysis::ModelTaxel& own = result.fit.model.taxels.emplace_back();
    own.taxel = taxel;
    own.status = taxel < 16 ? analysis::TaxelStatus::kDead : analysis::TaxelStatus::kFitted;
  }
  const std::string listed = verdict_page(result);
  CHECK_THAT(listed, Catch::StartsWith("\nsensor MY-1: ") &&
                         Catch::Contains(": limits 'gripper' only list figures: they state no verdict\nbad taxels: ") &&
                         Catch::EndsWith("row 5, column 0 (dead)\n"));
  result.fit.model.taxels[16].status = analysis::TaxelStatus::kDead;
  CHECK_THAT(verdict_page(result), Catch::EndsWith("row 5, column 0 (dead); and 1 more, in the report\n"));
  result.fit.model.taxels.clear();
  CHECK_THAT(verdict_page(result), Catch::EndsWith("\nbad taxels: none\n"));
}

TEST_CASE(
    "calibrate words: an earlier verdict that is worse is the reason, and a value within the uncertainty says so") {
  Judgement judgement = judgement_of({kGood});
  judgement.notes.stored_worse = {kDead};
  CHECK(reason_text(judgement, "gripper", 2) == "an earlier verdict on these models is fail");
  CHECK(reason_text(judgement_of({row("mean_compensation_error", "array", 1.1, 1, "psi", "conditional fail")}), "x", 2,
                    analysis::PressureUnit::kKilopascal) ==
        "mean absolute error: 7.58 kPa (tolerance limit 6.89 kPa), within the uncertainty above the limit, on held-out "
        "run 2");
}
