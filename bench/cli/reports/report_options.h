// What `report` is asked for, and whether it can be asked for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/reporting/report_results.h"

namespace tactbench::bench {

struct ReportOptions {
  std::vector<std::int64_t> runs, held_out;
  std::int64_t model_run = 0;  // 0: the run's own models
  std::string format = "html", limits, lab, output, approve_by, issued, paper = "a4", pdf_with;
  bool compare = false, batch = false, without_verdict = false;
  ReportExtras extras;
};

// Options that go together. Throws TB-USAGE.
void check_report_options(const ReportOptions& options);

// Everything that the command line names is there and may be rested on (named_runs.h). The report's own run is shown
// even when it is void.
void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session);

}  // namespace tactbench::bench
