// The ladder of verdicts, and verdicts of several runs together: the worst one, whatever the order.
#include "analysis/judgement/verdict.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "analysis/report/report.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::VerdictRecord of_run(std::int64_t run, const std::string& verdict) {
  db::VerdictRecord record;
  record.run = run;
  record.verdict = verdict;
  return record;
}
db::VerdictRecord of_run(std::int64_t run, Verdict verdict) { return of_run(run, std::string(to_string(verdict))); }

}  // namespace

TEST_CASE("each verdict has one word, and stores keep all but report only") {
  const std::vector<std::string> ladder = {"report only",      "pass",         "conditional pass",
                                           "conditional fail", "inconclusive", "fail"};
  std::vector<std::string> words;
  for (const Verdict verdict : kVerdicts) {
    words.emplace_back(to_string(verdict));
    CHECK(verdict_from(words.back()) == verdict);
    CHECK(verdict_word(verdict) == words.back());
    CHECK(verdict_in(of_run(1, verdict)) == verdict);
  }
  CHECK(words == ladder);
  CHECK(std::ranges::is_sorted(kVerdicts));
  CHECK(verdict_words() == std::vector<std::string>(ladder.begin() + 1, ladder.end()));
  for (const char* other : {"", "Pass", "passed", "warning"}) CHECK_FALSE(verdict_from(other));
  CHECK(verdict_word(std::nullopt).empty());
  CHECK(verdict_in(of_run(1, "a word of another program")) == Verdict::kInconclusive);
}

TEST_CASE("of two runs the worse decides, in whatever order they come") {
  for (const Verdict a : kVerdicts)
    for (const Verdict b : kVerdicts) CHECK(overall_verdict(std::vector{of_run(1, a), of_run(2, b)}) == std::max(a, b));
}

TEST_CASE("a run is as good as the worst of its criteria, and all that share the overall verdict decide") {
  const std::vector<db::VerdictRecord> rows = {of_run(7, "pass"), of_run(3, "fail"), of_run(7, "fail"),
                                               of_run(4, "pass"), of_run(3, "pass")};
  const std::vector<RunVerdict> runs = verdicts_by_run(rows);
  REQUIRE(runs.size() == 3);
  CHECK((runs[0].run == 7 && runs[0].verdict == Verdict::kFail));
  CHECK((runs[1].run == 3 && runs[1].verdict == Verdict::kFail));
  CHECK((runs[2].run == 4 && runs[2].verdict == Verdict::kPass));
  CHECK(deciding_runs(rows) == std::vector<std::int64_t>{3, 7});
  CHECK_FALSE(overall_verdict({}));
  CHECK(deciding_runs({}).empty());
}

TEST_CASE("verdicts without evidence become inconclusive, report-only verdicts do not change") {
  std::vector<db::VerdictRecord> rows = {of_run(1, "pass"), of_run(1, "fail"), of_run(1, "report only")};
  withhold_verdicts(rows);
  CHECK(rows[0].verdict == "inconclusive");
  CHECK(rows[1].verdict == "inconclusive");
  CHECK(rows[2].verdict == "report only");
  CHECK_FALSE(states_conformity(std::nullopt));
  for (const Verdict verdict : kVerdicts) CHECK(states_conformity(verdict) == (verdict != Verdict::kReportOnly));
}

TEST_CASE("rows that are not judged are inconclusive, and a stored fail outlives what was found now") {
  const std::vector<db::VerdictRecord> passes = {of_run(2, "pass")};
  JudgementNotes notes;
  CHECK(final_verdict(passes, notes) == Verdict::kPass);
  CHECK_FALSE(final_verdict({}, notes));
  notes.stored_worse = {of_run(3, "conditional fail")};
  CHECK(final_verdict(passes, notes) == Verdict::kPass);  // said beside it, by other limits
  notes.stored_worse.push_back(of_run(4, "fail"));
  CHECK(final_verdict(passes, notes) == Verdict::kFail);
  CHECK(final_verdict({}, notes) == Verdict::kFail);
  notes.not_judged = "no independent data";
  CHECK(final_verdict(passes, notes) == Verdict::kInconclusive);
}
