// The exit code of each verdict, and the words printed for it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>

#include "bench/cli/judgement_words.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/nightly/suite.h"
#include "sequences/toml/strict_toml.h"

using namespace tactbench;
using namespace tactbench::bench;
using analysis::Verdict;

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
