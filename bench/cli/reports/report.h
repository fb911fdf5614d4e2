// The verb `report`: its options and their checks, the choice of runs and models, and the writing of reports, also for
// other verbs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/report/document/document.h"
#include "analysis/report/report.h"
#include "bench/cli/runs/runs.h"
#include "bench/cli/session.h"
#include "bench/common/work_progress.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/signed_reports.h"

namespace tactbench::bench {

inline constexpr const char* kNoPrevious = "none";  // of --previous

struct ReportOptions {
  std::vector<std::string> named;  // runs as typed; choose_runs() derives `runs` from them and from `metadata`
  MetadataOptions metadata;
  std::vector<std::int64_t> runs, held_out;
  std::string model;  // RUN or RUN:FIT; empty: the models of the run itself
  std::string format = "html", limits, lab, output, signed_by, reason, issued, paper = "a4", pdf_with;
  std::vector<std::string> annexes;  // of analysis::kAnnexes, or "all"
  bool compare = false, batch = false, without_verdict = false;
  ReportExtras extras;
  SignerFiles signer;  // of report sign
};

// The run and the fit whose models are used. fit 0: the newest that was not replaced, dynamic or ELAM. {`run`, 0} if
// none is named.
struct ModelReference {
  std::int64_t run = 0, fit = 0;
};
// Throws TB-USAGE.
ModelReference parse_model_reference(const std::string& text, std::int64_t run);

// The named runs; with --batch also the runs of ranges, of a lot or of an order that have models and are not void.
// Throws TB-USAGE.
void choose_runs(ReportOptions& options, const db::RunStore& store, bool void_too);

// Checks that the options go together. Throws TB-USAGE.
void check_report_options(const ReportOptions& options);

// Throws TB-RUN-OWN for a run from which lag or creep of the models was fitted: it is not independent data for them.
void check_independent_of_dynamics(const db::RunReader& store, const analysis::SensorModel& fit,
                                   const std::vector<std::int64_t>& held_out);

// Checks that models named by RUN:FIT come from a run of the bench and have single taxels. Throws TB-USAGE.
void check_models_of_array(analysis::Runs& runs, const analysis::SensorModel& fit, const ModelReference& named);

// The stages of `report` for its progress line.
inline constexpr const char* kWritingReport = "writing";  // the last stage

// Writes the reports of `report`, also for other verbs that write a report.
struct WrittenReport {
  analysis::Report report;
  std::string dcc;                                  // if that format was requested
  std::vector<analysis::Judgement> judgements;      // for each run on the page
  std::string origin, started_utc, path, run_uuid;  // run_uuid: of the first run
  analysis::doc::Document summary;                  // for a table, which has no judgement
  std::string as_found;   // a line about the run judged by earlier models; empty: there are none
  std::string signature;  // FILE.p7s; empty: no key was named
  bool written = true;    // false: the file already held this report, signed
};

// Writes the page for these options and sets session.code by its verdict; prints only notes and warnings. Throws Error,
// sequences::FileError, db::StoreError, analysis::AnalysisError.
WrittenReport write_reports(ReportOptions options, Session& session);

}  // namespace tactbench::bench
