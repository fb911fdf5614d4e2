// The runs that a report's verdicts are about, as named on page 1.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/parts.h"

namespace tactbench::analysis {

struct JudgedColumn {
  std::int64_t number = 0;             // in the verdicts
  std::string title;                   // "held-out run", "own run (calibration data)"
  const db::RunRecord* run = nullptr;  // null: no part of this report
  const JudgedRun* judged = nullptr;   // verdict and trajectory; null: it is not judged
};
// In the order of the verdicts.
std::vector<JudgedColumn> judged_runs(const ReportInput& input);
std::string title_of_judged(const ReportInput& input, std::int64_t run);

// The part "All requirements together": the verdict, the deciding run, and remarks on the judgement.
html::Markup overall_part(const ReportInput& input);
// The runs judged, and what was not assessed.
html::Markup judged_runs_part(const ReportInput& input);

// Requirements with a column of value, U and verdict for each run; for two runs or more.
html::Markup criteria_by_run(const ReportInput& input);

// Cells shared by the tables of one and of several runs (sections/verdicts.cpp).
html::Markup judged_value(const JudgedFigure& figure, PressureUnit unit);
// Value ± U where U is known and not 0.
html::Markup judged_with_uncertainty(const JudgedFigure& figure, PressureUnit unit);
html::Markup judged_limit(const JudgedFigure& figure, PressureUnit unit);
html::Markup judged_mark(const ReportInput& input, const JudgedFigure& figure);

}  // namespace tactbench::analysis
