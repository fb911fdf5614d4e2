// The options of `report`, and their checks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/runs/metadata_options.h"
#include "bench/cli/session.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/signature.h"

namespace tactbench::bench {

inline constexpr const char* kNoPrevious = "none";  // of --previous

struct ReportOptions {
  std::vector<std::string> named;  // runs as typed; choose_runs() makes `runs` of them and of `metadata`
  MetadataOptions metadata;
  std::vector<std::int64_t> runs, held_out;
  std::string model;  // RUN or RUN:FIT; empty: the run's own
  std::string format = "html", limits, lab, output, signed_by, reason, issued, paper = "a4", pdf_with;
  std::vector<std::string> annexes;  // of analysis::kAnnexes, or "all"
  bool compare = false, batch = false, without_verdict = false;
  ReportExtras extras;
  SignerFiles signer;  // of report sign
};

// Those of a report, and further those of signing one. `options` outlives the parsing.
void add_report_options(CLI::App& verb, ReportOptions& options, Session& session);
void add_sign_options(CLI::App& verb, ReportOptions& options);

// The run and fit (0: the standing one, of its dynamic model and ELAM the newer) whose models are used; {`run`, 0}
// where none is named.
struct ModelNamed {
  std::int64_t run = 0, fit = 0;
};
// Throws TB-USAGE.
ModelNamed model_named(const std::string& text, std::int64_t run);

// The runs named; with --batch also of ranges and of a lot or order those that have models and count. Throws TB-USAGE.
void choose_runs(ReportOptions& options, const db::RunStore& store, bool void_too);

// Options that go together. Throws TB-USAGE.
void check_report_options(const ReportOptions& options);

// Runs that lag and creep of the models were taken from are no independent data for them. Throws TB-RUN-OWN.
void check_independent_of_dynamics(const db::RunStore& store, const analysis::SensorModel& fit,
                                   const std::vector<std::int64_t>& held_out);

// Models named by RUN:FIT are of a run that the bench made and of single taxels. Throws TB-USAGE.
void check_models_of_array(analysis::Runs& runs, const analysis::SensorModel& fit, const ModelNamed& named);

// Checks that all runs on the command line exist and may be used (named_runs.h). The report's own run may be void.
void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session);

}  // namespace tactbench::bench
