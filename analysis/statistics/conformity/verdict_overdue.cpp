// Withholds statements of conformity that rest on an overdue reference.
#include "analysis/statistics/conformity/verdict.h"

namespace tactbench::analysis {
namespace {

bool rests_on_reference(const db::VerdictRecord& verdict) {
  return verdict.criterion == "mean_compensation_error" || verdict.criterion == "worst_taxel_error" ||
         verdict.criterion == "mpe";
}

}  // namespace

void withhold_overdue(std::vector<db::VerdictRecord>& verdicts, std::int64_t run,
                      const ReferenceUncertainty& reference) {
  if (!reference.overdue) return;
  for (db::VerdictRecord& verdict : verdicts)
    if (verdict.run == run && verdict_in(verdict) != Verdict::kReportOnly && rests_on_reference(verdict))
      verdict.verdict = to_string(Verdict::kInconclusive);
}

}  // namespace tactbench::analysis
