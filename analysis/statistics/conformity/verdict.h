// Conformity: figures of an evaluation held against limits by a decision rule (ILAC-G8:09/2019), and the uncertainty of
// each judged figure, which is not that of a taxel's reading.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/statistics/conformity/overall_verdict.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/limits.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

// simple      w = 0: pass when value <= limit
// guarded     w = U: pass when value <= limit - U, else fail
// four-way    w = U: pass up to limit - U, conditional pass up to the limit, conditional fail up to limit + U, else
// fail report-only no verdict
const char* to_string(DecisionRule rule);  // "default", "simple", "guarded", "four-way", "report-only"
std::optional<DecisionRule> decision_rule_from(std::string_view word);
// The rule and its risk in words, for reports. Unknown words are returned unchanged.
std::string rule_in_words(const std::string& rule);

struct MpeFigure;  // mpe.h

// U of one judged figure: k = t_95.45 of the effective degrees of freedom.
struct JudgedUncertainty {
  std::string criterion, scope, unit;  // as in the verdict
  double expanded = 0.0;               // U in `unit`; NaN: not known
  double combined = 0.0, dof = 0.0, factor = 0.0;
  std::string basis;     // how it is formed
  std::string missing;   // why it is not known; empty: it is
  std::int64_t run = 0;  // judged
};

// Of all criteria, mismatch on every level. `evaluation` is that of `judged`, `reference` is the one of its run:
//   mean_compensation_error, worst_taxel_error   a common error of the reference moves them by at most itself (triangle
//                                                inequality): c = 1, not known without a certificate. Scatter: of a
//                                                taxel from repeat to repeat, pooled over the taxels, / sqrt(repeats)
//   distance_of_mean                             the reference's error cancels in differences at one level. Scatter: of
//                                                the array's mean from full sweep to full sweep, pooled over the levels
//   mismatch                                     likewise; scatter of the figure from full sweep to full sweep
//   unfit_taxels                                 a count by rule: U = 0
// Pooling (pooled_scatter.h) states its own degrees of freedom (JCGM 100, H.3.6). The scatter is that of `judged`, or
// of `models` (the run that they were made from) where `judged` has one repeat, or one full sweep. Throws as
// evaluate().
std::vector<JudgedUncertainty> judged_uncertainties(const Dataset& judged, const Dataset& models,
                                                    const SensorModel& fit, const Evaluation& evaluation,
                                                    const ReferenceUncertainty& reference, int threads = 0);
// nullptr where there is none. `run` 0: of any.
const JudgedUncertainty* find_uncertainty(std::span<const JudgedUncertainty> uncertainties, std::string_view criterion,
                                          std::string_view scope, std::int64_t run = 0);

// `expanded` NaN: not known; then guarded and four-way are inconclusive, since a weaker rule must not replace the
// requested one. Equality passes.
Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded);

// Whether judging by `rule` asks for judged_uncertainties().
bool needs_uncertainty(DecisionRule rule);

// Criteria mean_compensation_error, worst_taxel_error, distance_of_mean, unfit_taxels (scope "array") and mismatch
// (scopes "40 psi up", "40 psi down"), and mpe, one figure of `mpe` for each [[mpe]] of the limits. A value that is not
// a number, or a level that was not measured, is inconclusive. The rule in each record is the one applied. `fit` in the
// records is 0: the caller knows the fit's number.
std::vector<db::VerdictRecord> judge(const Evaluation& evaluation, const SensorModel& fit, const Limits& limits,
                                     std::span<const JudgedUncertainty> uncertainties = {},
                                     std::span<const MpeFigure> mpe = {});

// What rests on the pressure reference (mean_compensation_error, worst_taxel_error, mpe) is inconclusive where the
// reference was overdue when `run` was made, or where its certificate does not reach, whatever U and limit say; the
// other criteria hold differences and counts. Verdicts of other runs and "report only" stay. `reference` is that of
// `run`.
void withhold_untraced(std::vector<db::VerdictRecord>& verdicts, std::int64_t run,
                       const ReferenceUncertainty& reference);

}  // namespace tactbench::analysis
