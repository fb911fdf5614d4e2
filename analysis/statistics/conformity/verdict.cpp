#include "analysis/statistics/conformity/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/loop.h"
#include "analysis/statistics/conformity/mpe.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

struct DecisionRuleText {
  DecisionRule rule;
  const char* word;
  const char* text;
};

constexpr std::array<DecisionRuleText, 5> kDecisionRules = {{
    {DecisionRule::kDefault, "default", "four-way where the uncertainty is known, simple where it is not"},
    {DecisionRule::kSimple, "simple",
     "pass when the value is at most the limit. The uncertainty is not taken into account (w = 0): for a value at the "
     "limit the risk of a false acceptance, and of a false rejection, is up to 50 %"},
    {DecisionRule::kGuarded, "guarded",
     "pass when the value is at most the limit less U (guard band w = U), else fail. The risk of a false acceptance is "
     "below 2.5 %; a value within U below the limit is rejected, which is more likely wrong than right"},
    {DecisionRule::kFourWay, "four-way",
     "pass up to the limit less U, conditional pass up to the limit, conditional fail up to the limit plus U, fail "
     "above (w = U). The risk of a false acceptance is below 2.5 % for a pass and up to 50 % for a conditional pass; "
     "the risk of a false rejection is below 2.5 % for a fail and up to 50 % for a conditional fail"},
    {DecisionRule::kReportOnly, "report-only", "values and limits are reported, conformity is not stated"},
}};

}  // namespace

const char* to_string(DecisionRule rule) { return kDecisionRules[static_cast<std::size_t>(rule)].word; }

std::optional<DecisionRule> decision_rule_from(std::string_view word) {
  const auto* const found = std::ranges::find(kDecisionRules, word, &DecisionRuleText::word);
  return found == kDecisionRules.end() ? std::nullopt : std::optional(found->rule);
}

std::string rule_in_words(const std::string& rule) {
  const auto* const found = std::ranges::find(kDecisionRules, std::string_view(rule), &DecisionRuleText::word);
  return found == kDecisionRules.end() ? rule : fmt::format("“{}” (ILAC-G8:09/2019): {}", rule, found->text);
}

Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded) {
  if (rule == DecisionRule::kReportOnly) return Verdict::kReportOnly;
  if (std::isnan(value) || std::isnan(limit)) return Verdict::kInconclusive;
  if (rule == DecisionRule::kDefault) rule = std::isnan(expanded) ? DecisionRule::kSimple : DecisionRule::kFourWay;
  if (rule == DecisionRule::kSimple) return value <= limit ? Verdict::kPass : Verdict::kFail;
  if (std::isnan(expanded)) return Verdict::kInconclusive;
  if (value <= limit - expanded) return Verdict::kPass;
  if (rule == DecisionRule::kGuarded || value > limit + expanded) return Verdict::kFail;
  return value <= limit ? Verdict::kConditionalPass : Verdict::kConditionalFail;
}

bool needs_uncertainty(DecisionRule rule) { return rule != DecisionRule::kSimple && rule != DecisionRule::kReportOnly; }

const JudgedUncertainty* find_uncertainty(std::span<const JudgedUncertainty> uncertainties, std::string_view criterion,
                                          std::string_view scope, std::int64_t run) {
  const auto found = std::ranges::find_if(uncertainties, [&](const JudgedUncertainty& uncertainty) {
    return uncertainty.criterion == criterion && uncertainty.scope == scope && (run == 0 || uncertainty.run == run);
  });
  return found == uncertainties.end() ? nullptr : &*found;
}

std::vector<db::VerdictRecord> judge(const Evaluation& evaluation, const SensorModel& fit, const Limits& limits,
                                     std::span<const JudgedUncertainty> uncertainties, std::span<const MpeFigure> mpe) {
  std::vector<db::VerdictRecord> verdicts;
  const auto add = [&](const std::string& criterion, const std::string& scope, double value, double limit,
                       const std::string& unit) {
    const JudgedUncertainty* const known = find_uncertainty(uncertainties, criterion, scope);
    const double expanded = known == nullptr ? kNan : known->expanded;
    DecisionRule rule = limits.rule;
    if (rule == DecisionRule::kDefault) rule = std::isnan(expanded) ? DecisionRule::kSimple : DecisionRule::kFourWay;
    db::VerdictRecord record;
    record.run = evaluation.run;
    record.criterion = criterion;
    record.scope = scope;
    record.value = value;
    record.limit = limit;
    record.unit = unit;
    record.rule = to_string(rule);
    record.verdict = to_string(verdict_of(rule, value, limit, expanded));
    record.limits_toml = limits.toml;
    record.limits_sha256 = limits.sha256;
    verdicts.push_back(std::move(record));
  };
  const bool any = evaluation.frames > 0 && evaluation.worst_taxel >= 0;
  add("mean_compensation_error", "array", any ? evaluation.mean_error_psi : kNan, limits.mean_compensation_error_psi,
      "psi");
  add("worst_taxel_error", "array", any ? evaluation.worst_taxel_mean_error_psi : kNan, limits.worst_taxel_error_psi,
      "psi");
  add("distance_of_mean", "array", evaluation.levels.empty() ? kNan : evaluation.comp_distance_of_mean,
      limits.distance_of_mean_fs, "FS");
  const std::size_t unfit = fit.array().size() - fit.fitted().size();
  add("unfit_taxels", "array", static_cast<double>(unfit), limits.unfit_taxels, "taxels");
  for (const Limits::Mismatch& mismatch : limits.mismatch) {
    const auto off = [&](const LevelFigures& figures) {
      return std::abs(figures.pressure_psi - mismatch.pressure_psi);
    };
    const auto level = std::ranges::min_element(evaluation.levels, {}, off);
    const bool measured = level != evaluation.levels.end() && off(*level) <= kTypedLevelPsi;
    const std::string scope = fmt::format("{:g} psi", measured ? level->pressure_psi : mismatch.pressure_psi);
    add("mismatch", fmt::format("{} up", scope), measured ? level->comp_std_up : kNan, mismatch.std_fs, "FS");
    add("mismatch", fmt::format("{} down", scope), measured ? level->comp_std_down : kNan, mismatch.std_fs, "FS");
  }
  for (std::size_t i = 0; i < limits.mpe.size(); ++i)
    add("mpe", scope_of(limits.mpe[i]), i < mpe.size() ? mpe[i].value_psi : kNan, limits.mpe[i].mpe_psi, "psi");
  return verdicts;
}

}  // namespace tactbench::analysis
