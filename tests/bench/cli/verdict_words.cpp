// The exit code of each verdict, and a judgement as programs read it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/cli/judgement_words.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/nightly/suite.h"
#include "sequences/toml/strict_toml.h"

using namespace tactbench;
using namespace tactbench::bench;
using analysis::Verdict;

namespace {

db::VerdictRecord judged_row(std::int64_t run, const char* verdict) {
  db::VerdictRecord row;
  row.run = run;
  row.model_run = 1;
  row.criterion = "unfit_taxels";
  row.scope = "array";
  row.unit = "taxels";
  row.verdict = verdict;
  return row;
}

Judgement judged_rows(const std::vector<std::pair<std::int64_t, const char*>>& rows) {
  Judgement judgement;
  for (const auto& [run, verdict] : rows) judgement.verdicts.push_back(judged_row(run, verdict));
  return judgement;
}

analysis::JudgedTrajectory trajectory_of(std::int64_t run) {
  analysis::JudgedTrajectory judged;
  judged.run = run;
  judged.reversals = 1;
  judged.inner_share = 0.25;
  judged.dwell_s = 2.0;
  return judged;
}

}  // namespace

TEST_CASE("each verdict has its exit code, and what is worse never ends better") {
  CHECK(exit_code_of(std::nullopt) == ExitCode::kPass);
  CHECK(exit_code_of(Verdict::kReportOnly) == ExitCode::kPass);
  CHECK(exit_code_of(Verdict::kPass) == ExitCode::kPass);
  CHECK(exit_code_of(Verdict::kConditionalPass) == ExitCode::kPass);
  CHECK(exit_code_of(Verdict::kConditionalFail) == ExitCode::kInconclusive);
  CHECK(exit_code_of(Verdict::kInconclusive) == ExitCode::kInconclusive);
  CHECK(exit_code_of(Verdict::kFail) == ExitCode::kCriterionFailed);
  const std::vector<ExitCode> better_first = {ExitCode::kPass, ExitCode::kInconclusive, ExitCode::kCriterionFailed};
  std::ptrdiff_t before = 0;
  for (const Verdict verdict : analysis::kVerdicts) {
    const auto place = std::ranges::find(better_first, exit_code_of(verdict)) - better_first.begin();
    CHECK(place >= before);
    before = place;
  }
}

TEST_CASE("the verdict of a judgement counts what is stored, and withholds what is not judged") {
  Judgement judgement;
  CHECK_FALSE(verdict_of(judgement));
  db::VerdictRecord row;
  row.verdict = "conditional pass";
  judgement.verdicts = {row};
  CHECK(verdict_of(judgement) == Verdict::kConditionalPass);
  row.verdict = "fail";
  judgement.notes.stored_worse = {row};
  CHECK(verdict_of(judgement) == Verdict::kFail);
  CHECK(exit_code_of(judgement) == ExitCode::kCriterionFailed);
  judgement.notes.not_judged = "no independent data";
  CHECK(verdict_of(judgement) == Verdict::kInconclusive);
}

TEST_CASE("a run's stored verdict: fail by any limits, else the worst by the newest limits") {
  const auto row = [](const char* verdict, const char* limits) {
    db::VerdictRecord record;
    record.run = 2;
    record.model_run = 1;
    record.verdict = verdict;
    record.limits_sha256 = limits;
    return record;
  };
  CHECK_FALSE(standing_verdict({}));
  CHECK(standing_verdict({row("inconclusive", "old"), row("pass", "new")}) == Verdict::kPass);
  CHECK(standing_verdict({row("fail", "old"), row("pass", "new")}) == Verdict::kFail);
  CHECK(standing_verdict({row("pass", "new"), row("conditional fail", "new")}) == Verdict::kConditionalFail);
}

TEST_CASE("a suite can expect every verdict that a store can hold, and no other") {
  const auto suite = [](const std::string& word) {
    return parse_suite(
        "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\nheld_out = []\n"
        "[scenario.verdicts]\noverall = \"" +
            word + "\"\n",
        "s.toml");
  };
  for (const std::string& word : analysis::verdict_words())
    CHECK(suite(word).scenarios.at(0).verdicts.at("overall") == word);
  CHECK_THROWS_AS(suite("report only"), sequences::FileError);
}

TEST_CASE("an empty name of the operator is refused") {
  for (const char* nobody : {"", " ", " \t\r\n"}) CHECK_THROWS_AS(check_operator(nobody), Error);
  CHECK_NOTHROW(check_operator(" A. Operator"));
}

TEST_CASE("judgement as JSON: all of it, and an empty word for none") {
  Judgement judgement = judged_rows({{4, "fail"}, {2, "pass"}});
  judgement.notes.trajectories = {trajectory_of(2)};
  judgement.notes.not_assessed = {{"re-mounting", "no run"}};
  judgement.notes.stored_worse = {judged_row(5, "fail")};
  judgement.notes.remarks = {"a"};
  judgement.notes.untraced = "reference overdue";
  db::RunRecord gone;
  gone.run = 9;
  gone.void_reason = "door";
  gone.void_by = "K. Lee";
  gone.void_utc = "2026-01-01T00:00:00Z";
  judgement.void_runs = {gone};
  const auto json = judgement_json(judgement, "simulated");
  CHECK(json.at("overall") == "fail");
  CHECK(json.at("shown") == "simulated fail");
  CHECK_THAT(json.at("statement").get<std::string>(), Catch::StartsWith("fail"));
  REQUIRE(json.at("trajectories").size() == 1);
  CHECK(json.at("trajectories").at(0).at("run") == 2);
  CHECK(json.at("not_assessed") == nlohmann::ordered_json::parse(R"([{"source": "re-mounting", "why": "no run"}])"));
  CHECK(json.at("untraced") == "reference overdue");
  CHECK(json.at("not_judged") == "");
  CHECK(json.at("runs") ==
        nlohmann::ordered_json::parse(R"([{"run": 4, "verdict": "fail"}, {"run": 2, "verdict": "pass"}])"));
  CHECK(json.at("decided_by") == nlohmann::ordered_json({4}));
  CHECK(json.at("void_runs") ==
        nlohmann::ordered_json::parse(
            R"([{"run": 9, "reason": "door", "by": "K. Lee", "utc": "2026-01-01T00:00:00Z"}])"));
  REQUIRE(json.at("stored_worse").size() == 1);
  CHECK(json.at("stored_worse").at(0).at("shown") == "simulated fail");
  CHECK(json.at("remarks") == nlohmann::ordered_json({"a"}));
  judgement.notes.not_judged = "no independent data";
  CHECK(judgement_json(judgement, "hardware").at("shown") == "inconclusive");
  const auto nothing = judgement_json({}, "simulated");
  CHECK(nothing.at("shown") == "");
  CHECK(nothing.at("statement") == "");
  CHECK(nothing.at("runs").empty());
}
