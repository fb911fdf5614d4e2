// Text of judged figures, their limits and decision rules, for the report's pages.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/document/document.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

// "held-out run 2", "own run (calibration data)".
std::string title_of_judged(const ReportInput& input, std::int64_t run);
// Null: not evaluated here.
const Evaluation* evaluation_of(const ReportInput& input, std::int64_t run);

// "43.5 ± 0.8 kPa", "1.50 % FS", "1 taxel"; without U if `expanded` is not known or 0.
doc::Phrase figure_phrase(Criterion criterion, double value, double expanded = 0.0);
// "non-uniformity, 275.8 kPa decreasing".
std::string requirement_name(const JudgedFigure& figure, PressureUnit unit);
// The rules applied to its figures, each once, in the order of the figures.
std::vector<DecisionRule> rules_of(const Judgement& judgement);

}  // namespace tactbench::analysis
