#include "bench/cli/reports/report_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "bench/cli/runs/source.h"
#include "bench/reporting/named_runs.h"

namespace tactbench::bench {

void check_report_options(const ReportOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error(ExitCode::kUsage, "TB-USAGE", what, "report", remedy);
  };
  if (options.compare && options.batch) refuse("--compare and --batch cannot be combined", "give one of them");
  if (options.compare && options.runs.size() != 2)
    refuse(fmt::format("--compare takes two runs, not {}", options.runs.size()), "tactbench report --compare 1 2");
  const bool several = options.compare || options.batch;
  if (several && (!options.approve_by.empty() || !options.held_out.empty() || !options.lab.empty() ||
                  !options.extras.previous.empty() || !options.extras.studies.empty()))
    refuse("--approve-by, --held-out, --lab, --previous and --studies belong to the report of one run",
           "report each run by itself, then compare");
  if (!options.issued.empty() && !analysis::is_date(options.issued))
    refuse(fmt::format("'{}' is not a date", options.issued), "write it as 2026-01-31");
}

void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  const std::int64_t run = options.runs.front();
  (void)runs.record(run);  // an unknown run is reported first
  if (options.compare || options.batch) {
    (void)named_runs(runs, options.runs, {"report --compare and --batch"}, session.void_too);
    return;
  }
  const std::int64_t model_run = options.model_run != 0 ? options.model_run : run;
  if (model_run != run) (void)named_runs(runs, {model_run}, {"--model"}, session.void_too);
  (void)named_runs(runs, {options.runs.begin() + 1, options.runs.end()}, {"runs after the report's own"},
                   session.void_too);
  std::vector<std::int64_t> independent = options.held_out;
  (void)named_runs(runs, independent, {"--held-out", model_run}, session.void_too);
  if (std::ranges::find(independent, run) != independent.end())
    throw Error(ExitCode::kUsage, "TB-RUN-TWICE", fmt::format("run {} is the report's own", run), "--held-out",
                "name only further runs: this one is included in any case");
  if (!options.extras.previous.empty()) check_model_named(runs, options.extras.previous, "--previous", session);
  std::vector<std::int64_t> studied;
  for (const StudyRun& study : study_runs_of(options.extras.studies))
    if (study.run != run) studied.push_back(study.run);
  (void)named_runs(runs, studied, {"--studies", model_run != run ? model_run : 0}, session.void_too);
}

}  // namespace tactbench::bench
