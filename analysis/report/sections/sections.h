// The report's sections, one function and one source each: pure functions of the input.
#pragma once

#include "analysis/report/page/html.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

// report.cpp renders these in order.
html::Markup verdict_section(const ReportInput& input);
html::Markup identification_section(const ReportInput& input);
html::Markup health_section(const ReportInput& input);
html::Markup raw_section(const ReportInput& input);
html::Markup loops_section(const ReportInput& input);
html::Markup frames_section(const ReportInput& input);
html::Markup levels_section(const ReportInput& input);
html::Markup model_section(const ReportInput& input);
html::Markup held_out_section(const ReportInput& input);
html::Markup uncertainty_section(const ReportInput& input);
html::Markup meaning_section(const ReportInput& input);
html::Markup models_section(const ReportInput& input);
html::Markup as_found_section(const ReportInput& input);
html::Markup compensation_section(const ReportInput& input);
html::Markup studies_section(const ReportInput& input);
html::Markup objects_section(const ReportInput& input);

// Parts of sections.
html::Markup instruments_part(const ReportInput& input);
html::Markup method_part(const ReportInput& input);
html::Markup elam_parameters_part(const ReportInput& input);
html::Markup conditions_part(const ReportInput& input);      // the table of conditions of use, beside the budgets
html::Markup conditions_in_brief(const ReportInput& input);  // the same in two sentences, for page 1; empty without U
html::Markup readings_in_brief(const ReportInput& input);    // for page 1: range of use, error and U at some levels
std::vector<double> level_pressures(const Uncertainty& uncertainty);  // rising, each once
// "−0.83 ± 2.3" of the median and of the worst taxel, `mark` before the latter.
html::Markup error_cells(const LevelUncertainty& level, PressureUnit unit, const char* mark = "");
html::Markup range_within(const Uncertainty& uncertainty, bool up, double most_psi, PressureUnit unit);
html::Markup array_uncertainty_part(const ReportInput& input);  // needs U
html::Markup usable_part(const ReportInput& input);
html::Markup uniformity_part(const Uniformity& uniformity, int rows, int columns, PressureUnit unit);
html::Markup remount_part(const Remount& remount, int rows, int columns, PressureUnit unit);
html::Markup contact_frames_part(const ContactResult& contact, int rows, int columns, PressureUnit unit);

}  // namespace tactbench::analysis
