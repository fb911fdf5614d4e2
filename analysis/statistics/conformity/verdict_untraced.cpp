// Withholds statements of conformity that rest on pressures which are not traceable.
#include <cstdio>

#include "analysis/statistics/conformity/verdict.h"

namespace tactbench::analysis {
namespace {

bool rests_on(const ReferenceUncertainty& reference, const db::VerdictRecord& verdict) {
  if (verdict.criterion == "mean_compensation_error" || verdict.criterion == "worst_taxel_error") return true;
  if (verdict.criterion != "mpe") return false;
  double low = 0.0, high = 0.0;  // of the scope, as scope_of() writes it
  const int ends = std::sscanf(verdict.scope.c_str(), "%lf-%lf", &low, &high);
  return reference.overdue || ends < 1 || !reference.holds_at(low) || (ends == 2 && !reference.holds_at(high));
}

}  // namespace

void withhold_untraced(std::vector<db::VerdictRecord>& verdicts, std::int64_t run,
                       const ReferenceUncertainty& reference) {
  if (reference.untraced().empty()) return;
  for (db::VerdictRecord& verdict : verdicts)
    if (verdict.run == run && verdict_in(verdict) != Verdict::kReportOnly && rests_on(reference, verdict))
      verdict.verdict = to_string(Verdict::kInconclusive);
}

}  // namespace tactbench::analysis
