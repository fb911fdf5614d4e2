// The stages of `report` for its progress line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/reports/report_options.h"
#include "bench/common/long_work.h"

namespace tactbench::bench {

inline constexpr const char* kWritingReport = "writing";  // the last stage
std::string report_stage_of(std::int64_t run);            // of a comparison or a batch
// Of one run: its figures, then "models" and "uncertainty" (bench/reporting/evaluation.cpp).
std::vector<WorkStage> report_stages(const ReportOptions& options);

}  // namespace tactbench::bench
