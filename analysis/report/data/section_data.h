// Data of the report's sections as JSON.
#pragma once

#include <string>

#include "analysis/report/report.h"

namespace tactbench::analysis {

// identification_json() holds what names the run (number, UUID, times, host), so that the content hash can omit it; the
// others hold results. JSON in ASCII; null where a figure is not available.
std::string identification_json(const ReportInput& input);
std::string approvals_json(const ReportInput& input);  // the signatures, a part of it
std::string results_json(const ReportInput& input);
std::string uncertainty_json(const ReportInput& input);
std::string health_json(const ReportInput& input);
std::string behaviour_json(const ReportInput& input);
std::string as_found_json(const ReportInput& input);
std::string studies_json(const ReportInput& input);
std::string objects_json(const ReportInput& input);

}  // namespace tactbench::analysis
