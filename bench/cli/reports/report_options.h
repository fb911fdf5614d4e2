// The options of `report`, and their checks.
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

// Checks that all runs on the command line exist and may be used (named_runs.h). The report's own run may be void.
void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session);

}  // namespace tactbench::bench
