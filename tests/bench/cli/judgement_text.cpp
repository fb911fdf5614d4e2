// A judgement as people and programs read it, line by line and member by member.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/cli/judgement_words.h"

using namespace tactbench;
using namespace tactbench::bench;

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

TEST_CASE("judgement as JSON: all of it, and an empty word where there is no verdict") {
  Judgement judgement = judged_rows({{4, "fail"}, {2, "pass"}});
  judgement.notes.trajectories = {trajectory_of(2)};
  judgement.notes.not_assessed = {{"re-mounting", "no run"}};
  judgement.notes.stored_worse = {judged_row(5, "fail")};
  judgement.notes.remarks = {"a"};
  judgement.notes.overdue = "reference overdue";
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
  CHECK(json.at("overdue") == "reference overdue");
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
