#include "analysis/judgement/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {
namespace {

constexpr std::array kVerdictNames = {"report only",      "pass",         "conditional pass",
                                      "conditional fail", "inconclusive", "fail"};
static_assert(kVerdictNames.size() == kVerdicts.size());

struct DecisionRuleText {
  DecisionRule rule;
  const char* word;
  const char* text;
};

constexpr std::array<DecisionRuleText, 5> kDecisionRules = {{
    {DecisionRule::kDefault, "default", "four-way if the uncertainty is known, simple if it is not"},
    {DecisionRule::kSimple, "simple",
     "pass when the value is at most the limit. The uncertainty is not taken into account (w = 0): for a value at the "
     "limit the risk of a false acceptance, and of a false rejection, is up to 50 %"},
    {DecisionRule::kGuarded, "guarded",
     "pass when the value is at most the limit less U (guard band w = U), else fail. The risk of a false acceptance is "
     "below 2.5 %; a value within U below the limit is rejected although it more probably conforms"},
    {DecisionRule::kFourWay, "four-way",
     "pass up to the limit less U, conditional pass up to the limit, conditional fail up to the limit plus U, fail "
     "above (w = U). The risk of a false acceptance is below 2.5 % for a pass and up to 50 % for a conditional pass; "
     "the risk of a false rejection is below 2.5 % for a fail and up to 50 % for a conditional fail"},
    {DecisionRule::kReportOnly, "report-only", "values and limits are reported; conformity is not stated"},
}};

const DecisionRuleText& text_of(DecisionRule rule) { return kDecisionRules.at(static_cast<std::size_t>(rule)); }

}  // namespace

const char* to_string(Verdict verdict) { return kVerdictNames.at(static_cast<std::size_t>(verdict)); }

std::optional<Verdict> verdict_from(std::string_view word) {
  for (const Verdict verdict : kVerdicts)
    if (word == to_string(verdict)) return verdict;
  return std::nullopt;
}

std::string verdict_text(std::optional<Verdict> verdict) { return verdict ? to_string(*verdict) : ""; }

std::vector<std::string> verdict_names() { return {kVerdictNames.begin() + 1, kVerdictNames.end()}; }

bool states_conformity(std::optional<Verdict> verdict) { return verdict && *verdict != Verdict::kReportOnly; }

bool passes(std::optional<Verdict> verdict) {
  return verdict == Verdict::kPass || verdict == Verdict::kConditionalPass;
}

const char* to_string(DecisionRule rule) { return text_of(rule).word; }

std::optional<DecisionRule> decision_rule_from(std::string_view word) {
  const auto* const found = std::ranges::find(kDecisionRules, word, &DecisionRuleText::word);
  return found == kDecisionRules.end() ? std::nullopt : std::optional(found->rule);
}

std::string rule_text(DecisionRule rule) {
  return fmt::format("“{}” (ILAC-G8:09/2019): {}", text_of(rule).word, text_of(rule).text);
}

DecisionRule rule_applied(DecisionRule asked, double expanded) {
  if (asked != DecisionRule::kDefault) return asked;
  return std::isnan(expanded) ? DecisionRule::kSimple : DecisionRule::kFourWay;
}

Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded) {
  rule = rule_applied(rule, expanded);
  if (rule == DecisionRule::kReportOnly) return Verdict::kReportOnly;
  if (std::isnan(value) || std::isnan(limit)) return Verdict::kInconclusive;
  if (rule == DecisionRule::kSimple) return value <= limit ? Verdict::kPass : Verdict::kFail;
  if (std::isnan(expanded)) return Verdict::kInconclusive;
  if (value <= limit - expanded) return Verdict::kPass;
  if (rule == DecisionRule::kGuarded || value > limit + expanded) return Verdict::kFail;
  return value <= limit ? Verdict::kConditionalPass : Verdict::kConditionalFail;
}

}  // namespace tactbench::analysis
