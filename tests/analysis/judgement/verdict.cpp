// The ladder of verdicts, and the decision rules at the limit and U to either side of it.
#include "analysis/judgement/figure.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace tactbench::analysis;

TEST_CASE("Verdict: each has its own name, and stores keep all except report only") {
  const std::vector<std::string> ladder = {"report only",      "pass",         "conditional pass",
                                           "conditional fail", "inconclusive", "fail"};
  std::vector<std::string> words;
  for (const Verdict verdict : kVerdicts) {
    words.emplace_back(to_string(verdict));
    CHECK(verdict_from(words.back()) == verdict);
    CHECK(verdict_text(verdict) == words.back());
    CHECK(states_conformity(verdict) == (verdict != Verdict::kReportOnly));
    CHECK(passes(verdict) == (verdict == Verdict::kPass || verdict == Verdict::kConditionalPass));
  }
  CHECK(words == ladder);
  CHECK(std::ranges::is_sorted(kVerdicts));
  CHECK(verdict_names() == std::vector<std::string>(ladder.begin() + 1, ladder.end()));
  for (const char* other : {"", "Pass", "passed", "warning"}) CHECK_FALSE(verdict_from(other));
  CHECK(verdict_text(std::nullopt).empty());
  CHECK_FALSE((states_conformity(std::nullopt) || passes(std::nullopt)));
}

TEST_CASE("decision rules: give the expected verdict at the limit and U to either side of it") {
  // Limit 2, U 0.25: both are exact in binary.
  const auto above = [](double value) { return std::nextafter(value, 9.0); };
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  using enum DecisionRule;
  struct Case {
    DecisionRule rule;
    double value, expanded;
    Verdict verdict;
  };
  for (const Case& each : {Case{kFourWay, -1.0, 0.25, Verdict::kPass},
                           Case{kFourWay, 1.75, 0.25, Verdict::kPass},
                           Case{kFourWay, above(1.75), 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, above(2.0), 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, 2.25, 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, above(2.25), 0.25, Verdict::kFail},
                           Case{kFourWay, 2.0, 0.0, Verdict::kPass},
                           Case{kFourWay, above(2.0), 0.0, Verdict::kFail},
                           Case{kFourWay, 1.0, kNotKnown, Verdict::kInconclusive},
                           Case{kFourWay, kNotKnown, 0.25, Verdict::kInconclusive},
                           Case{kSimple, 2.0, 0.25, Verdict::kPass},
                           Case{kSimple, above(2.0), 0.25, Verdict::kFail},
                           Case{kSimple, 2.0, kNotKnown, Verdict::kPass},
                           Case{kGuarded, 1.75, 0.25, Verdict::kPass},
                           Case{kGuarded, above(1.75), 0.25, Verdict::kFail},
                           Case{kGuarded, 1.0, kNotKnown, Verdict::kInconclusive},
                           Case{kDefault, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kDefault, 2.0, kNotKnown, Verdict::kPass},
                           Case{kReportOnly, 9.0, 0.25, Verdict::kReportOnly}}) {
    CAPTURE(to_string(each.rule), each.value, each.expanded);
    CHECK(verdict_of(each.rule, each.value, 2.0, each.expanded) == each.verdict);
  }
  CHECK(verdict_of(kDefault, 1.0, kNotKnown, 0.1) == Verdict::kInconclusive);
}

TEST_CASE("decision rules: convert to and from names, and their text states the probabilities") {
  for (const char* name : {"default", "simple", "guarded", "four-way", "report-only"}) {
    const auto rule = decision_rule_from(name);
    REQUIRE(rule);
    CHECK(std::string(to_string(*rule)) == name);
    CHECK_THAT(rule_text(*rule), Catch::Contains("ILAC-G8:09/2019"));
  }
  CHECK_FALSE(decision_rule_from("strict"));
  CHECK_THAT(rule_text(DecisionRule::kSimple), Catch::Contains("50 %"));
  CHECK_THAT(rule_text(DecisionRule::kGuarded), Catch::Contains("2.5 %"));
  CHECK_THAT(rule_text(DecisionRule::kFourWay), Catch::Contains("2.5 %") && Catch::Contains("50 %"));
}
