#include "bench/cli/reports/report_stages.h"

#include <fmt/format.h>

namespace tactbench::bench {

std::string report_stage_of(std::int64_t run) { return fmt::format("run {}", run); }

// Shares of the time as on the demonstration's runs; they only divide the time left.
std::vector<WorkStage> report_stages(const ReportOptions& options) {
  std::vector<WorkStage> stages;
  if (options.compare || options.batch)
    for (const std::int64_t run : options.runs) stages.push_back({report_stage_of(run), 2.0, false});
  else
    stages = {{"figures", 2.0, false}, {"models", 4.0, false}, {"uncertainty", 4.0, false}};
  stages.push_back({kWritingReport, options.format == "pdf" ? 8.0 : 1.0, false});
  return stages;
}

}  // namespace tactbench::bench
