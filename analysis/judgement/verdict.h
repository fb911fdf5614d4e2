// Verdicts and decision rules (ILAC-G8:09/2019). The store, JSON and printed output use their names; decisions compare
// the enum.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/statistics/figures/limits.h"

namespace tactbench::analysis {

// Best first, so that the worse of two is the larger. kReportOnly (no statement of conformity) ranks best and is never
// stored.
enum class Verdict { kReportOnly, kPass, kConditionalPass, kConditionalFail, kInconclusive, kFail };
inline constexpr std::array kVerdicts = {Verdict::kReportOnly,      Verdict::kPass,         Verdict::kConditionalPass,
                                         Verdict::kConditionalFail, Verdict::kInconclusive, Verdict::kFail};

// "report only", "pass", "conditional pass", "conditional fail", "inconclusive", "fail".
const char* to_string(Verdict verdict);
std::optional<Verdict> verdict_from(std::string_view word);
// Empty without a verdict.
std::string verdict_text(std::optional<Verdict> verdict);
// The words that a store may contain, best first.
std::vector<std::string> verdict_names();
// Whether the verdict states conformity or nonconformity: false without a verdict, and for report only.
bool states_conformity(std::optional<Verdict> verdict);
bool passes(std::optional<Verdict> verdict);  // also for a conditional pass

// Guard band w. Simple: w = 0, pass when value <= limit. Guarded: w = U, pass when value <= limit - U, else fail.
// Four-way: w = U, pass up to limit - U, conditional pass up to the limit, conditional fail up to limit + U, else fail.
// Report-only: no verdict.
const char* to_string(DecisionRule rule);  // "default", "simple", "guarded", "four-way", "report-only"
std::optional<DecisionRule> decision_rule_from(std::string_view word);
// Text on the rule and its risk, for reports.
std::string rule_text(DecisionRule rule);
// The rule that is applied: for kDefault, four-way if U (`expanded`) is known, simple if it is NaN.
DecisionRule rule_applied(DecisionRule asked, double expanded);

// `expanded` NaN: not known; then guarded and four-way are inconclusive, because a weaker rule must not replace the
// requested one. A value equal to the limit passes.
Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded);

}  // namespace tactbench::analysis
