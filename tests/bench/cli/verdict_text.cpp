// The exit code of each verdict, and a judgement as programs read it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/document/document.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/nightly/suite.h"
#include "sequences/toml/strict_toml.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::bench;
using analysis::Verdict;

TEST_CASE("verdict text: each verdict has its exit code, and a worse verdict never has a better code") {
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

namespace {

using analysis::by_hand::judged_figure;
using analysis::by_hand::judgement_of;

analysis::JudgedFigure mean_error(std::int64_t run, double value, double limit, Verdict verdict) {
  return judged_figure(run, analysis::Criterion::kMeanError, value, limit, verdict);
}

constexpr analysis::PressureUnit kPsi = analysis::PressureUnit::kPsi;

std::string shown(const analysis::Judgement& judgement, bool all = false) {
  return to_text(judgement_document(judgement, "simulated", kPsi, all), kPsi, 200);
}

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("verdict text: the verdict comes first, agrees with the exit code, and is followed by the deciding value") {
  for (const Verdict verdict :
       {Verdict::kPass, Verdict::kConditionalPass, Verdict::kConditionalFail, Verdict::kInconclusive, Verdict::kFail}) {
    INFO(to_string(verdict));
    const analysis::Judgement judgement =
        judgement_of({mean_error(2, 0.125, 3.0, Verdict::kPass), mean_error(3, 6.25, 3.0, verdict)});
    const ExitCode code = exit_code_of(verdict);
    const std::string word = verdict_banner(judgement), text = shown(judgement);
    CHECK(word == (code == ExitCode::kPass ? "PASS" : code == ExitCode::kInconclusive ? "INCONCLUSIVE" : "FAIL"));
    CHECK(text.starts_with(word + " (simulated)"));
    CHECK(text.substr(0, text.find('\n')).find("6.25 psi") != std::string::npos);
    CHECK(times(text, "simulated") == 1);
    CHECK(times(text, word) == 1);
  }
  CHECK(verdict_banner(judgement_of({mean_error(2, 1.0, 3.0, Verdict::kReportOnly)})).empty());
  analysis::Judgement own = judgement_of({mean_error(2, 1.0, 3.0, Verdict::kPass)});
  own.not_judged = {analysis::Remark::Kind::kNoIndependentData};
  conclude(own);
  CHECK(verdict_banner(own) == "INCONCLUSIVE");
}

TEST_CASE("verdict text: a pass based on means only is marked, and passed values are listed only on request") {
  std::vector<analysis::JudgedFigure> figures;
  for (const double value : {0.5, 1.5, 2.5, 1.0}) figures.push_back(mean_error(2, value, 3.0, Verdict::kPass));
  CHECK(times(headline(judgement_of(figures), "hardware", kPsi), "means") == 1);
  const std::string brief = shown(judgement_of(figures)), all = shown(judgement_of(figures), true);
  for (const char* value : {"0.50 psi", "1.50 psi", "1.00 psi"}) {
    CHECK(times(brief, value) == 0);
    CHECK(times(all, value) == 1);
  }
  CHECK(times(brief, "2.50 psi") == 1);  // the closest to its limit
  figures.push_back(judged_figure(2, analysis::Criterion::kMpe, 1.0, 3.0, Verdict::kPass));
  CHECK(times(headline(judgement_of(figures), "hardware", kPsi), "means") == 0);
  figures.push_back(mean_error(3, 9.0, 3.0, Verdict::kFail));
  figures.push_back(mean_error(4, 8.0, 3.0, Verdict::kFail));
  const std::string failed = shown(judgement_of(figures));
  CHECK(failed.find("9.00 psi") < failed.find("8.00 psi"));
  CHECK(failed.find("8.00 psi") < failed.find("2.50 psi"));  // the closest pass
}

TEST_CASE("pass by readings: names the kinds of history without U in any judged run, a fail names none") {
  using analysis::UseCondition;
  const auto of_kinds = [](std::int64_t run, Verdict verdict, std::vector<UseCondition> kinds) {
    analysis::JudgedFigure figure = judged_figure(run, analysis::Criterion::kMpe, 1.0, 3.0, verdict);
    figure.u.kinds = std::move(kinds);
    return figure;
  };
  const auto named = [](const analysis::Judgement& judgement) {
    std::vector<std::string> found;
    for (std::size_t kind = 0; kind < analysis::kHistoryKinds; ++kind)
      if (const std::string name = name_of(static_cast<UseCondition>(kind)); times(shown(judgement), name) == 1)
        found.push_back(name);
    CHECK(found == kinds_left_open(judgement));
    return found.size();
  };
  const auto sweeps = of_kinds(2, Verdict::kPass, {UseCondition::kFullSweeps, UseCondition::kReversals});
  CHECK(named(judgement_of({sweeps})) == 2);
  CHECK(named(judgement_of({sweeps, of_kinds(3, Verdict::kPass, {UseCondition::kHeld})})) == 1);
  CHECK(named(judgement_of({sweeps, of_kinds(3, Verdict::kFail, {})})) == 0);
  CHECK(named(judgement_of({of_kinds(2, Verdict::kPass, {})})) == 0);  // a stored one
}

TEST_CASE("suite: a scenario can expect every verdict that a store can hold, and no other") {
  const auto suite = [](const std::string& word) {
    return parse_suite(
        "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\nheld_out = []\n"
        "[scenario.verdicts]\noverall = \"" +
            word + "\"\n",
        "s.toml");
  };
  for (const std::string& word : analysis::verdict_names())
    CHECK(suite(word).scenarios.at(0).verdicts.at("overall") == word);
  CHECK_THROWS_AS(suite("report only"), sequences::FileError);
}

TEST_CASE("operator: an empty name is rejected") {
  for (const char* nobody : {"", " ", " \t\r\n"}) CHECK_THROWS_AS(check_operator(nobody), Error);
  CHECK_NOTHROW(check_operator(" A. Operator"));
}

TEST_CASE("verdict text: the judgement as JSON has all members, and empty text if there is no verdict") {
  using analysis::by_hand::judged_figure;
  const auto row = [](std::int64_t run, Verdict verdict) {
    return judged_figure(run, analysis::Criterion::kUnfitTaxels, 1.0, 1.0, verdict, {}, 1);
  };
  analysis::Judgement judgement = analysis::by_hand::judgement_of({row(4, Verdict::kFail), row(2, Verdict::kPass)});
  judgement.not_assessed = {analysis::Source::kRemounting};
  judgement.stored_worse = {row(5, Verdict::kFail)};
  judgement.void_counted = {{9, "K. Lee", "2026-01-01T00:00:00Z", "door"}};
  judgement.remarks = {{analysis::Remark::Kind::kVoidCounted, judgement.void_counted[0]}};
  judgement.untraced = analysis::TraceabilityGap{.overdue_since = "2020-01-31"};
  const auto json = judgement_json(judgement, "simulated");
  CHECK(json.at("overall") == "fail");
  CHECK(json.at("shown") == "simulated fail");
  CHECK_THAT(json.at("statement").get<std::string>(), Catch::StartsWith("fail"));
  REQUIRE(json.at("runs").size() == 2);
  CHECK((json["runs"][0]["run"] == 4 && json["runs"][0]["verdict"] == "fail"));
  CHECK(json["runs"][1].at("trajectory").contains("reversals"));
  CHECK((json.at("not_assessed").size() == 1 && json["not_assessed"][0]["source"] == "re-mounting"));
  CHECK_THAT(json.at("untraced").get<std::string>(), Catch::Contains("2020-01-31"));
  CHECK(json.at("not_judged") == "");
  CHECK(json.at("decided_by") == nlohmann::ordered_json({4}));
  CHECK((json.at("deciding").at("run") == 4 && json.at("closest_pass").at("run") == 2));
  CHECK(json.at("rests_on_means_alone") == false);
  CHECK(json.at("void_runs") ==
        nlohmann::ordered_json::parse(
            R"([{"run": 9, "reason": "door", "by": "K. Lee", "utc": "2026-01-01T00:00:00Z"}])"));
  CHECK((json.at("stored_worse").size() == 1 && json.at("remarks").size() == 1));
  judgement.not_judged = {analysis::Remark::Kind::kNoIndependentData};
  conclude(judgement);
  CHECK(judgement_json(judgement, "hardware").at("shown") == "inconclusive");
  const auto nothing = judgement_json({}, "simulated");
  CHECK((nothing.at("shown") == "" && nothing.at("statement") == "" && nothing.at("runs").empty()));
  CHECK(nothing.at("deciding").is_null());
}
