// Sections on what ReportInput::more holds, and the data behind them: models compared, compensation, further studies,
// arrays under objects. As those of page.h: pure functions of the input; JSON in ASCII that names no run.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/report/html.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

html::Markup models_section(const ReportInput& input);
html::Markup as_found_section(const ReportInput& input);
html::Markup compensation_section(const ReportInput& input);
html::Markup studies_section(const ReportInput& input);
html::Markup objects_section(const ReportInput& input);
std::string models_json(const ReportInput& input);
std::string compensation_json(const ReportInput& input);
std::string studies_json(const ReportInput& input);
std::string objects_json(const ReportInput& input);

// Parts of these, and of the section on ELAM.
html::Markup elam_parameters_part(const ReportInput& input);
html::Markup usable_part(const ReportInput& input);
html::Markup uniformity_part(const Uniformity& uniformity, int rows, int columns);
html::Markup remount_part(const Remount& remount, int rows, int columns);
html::Markup contact_frames_part(const ContactResult& contact, int rows, int columns);

}  // namespace tactbench::analysis
