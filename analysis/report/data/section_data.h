// The data behind the sections' figures.
#pragma once

#include <string>

#include "analysis/report/report.h"

namespace tactbench::analysis {

// What names the run (number, UUID, times, host) is apart from the results, so that the
// content hash can leave it out. JSON in ASCII; null where a figure is not available.
std::string identification_json(const ReportInput& input);
std::string results_json(const ReportInput& input);
std::string uncertainty_json(const ReportInput& input);
std::string health_json(const ReportInput& input);
std::string behaviour_json(const ReportInput& input);
std::string models_json(const ReportInput& input);
std::string compensation_json(const ReportInput& input);
std::string studies_json(const ReportInput& input);
std::string objects_json(const ReportInput& input);

}  // namespace tactbench::analysis
