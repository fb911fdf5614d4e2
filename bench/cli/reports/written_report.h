// Writes the reports of `report`, also for other verbs that write a report.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/document/document.h"
#include "analysis/report/report.h"
#include "bench/cli/reports/report_options.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

struct WrittenReport {
  analysis::Report report;
  std::string dcc;                                  // where that format was asked for
  std::vector<analysis::Judgement> judgements;      // of one run, or of each run on the page
  std::string origin, started_utc, path, run_uuid;  // run_uuid: of the first
  analysis::doc::Document summary;                  // of a table, which has no judgement
  std::string as_found;                             // a line on the run by earlier models; empty: there are none
  std::string signature;                            // FILE.p7s; empty: no key was named
  bool written = true;                              // false: the file held this report already, signed
};

// Writes the page of these options and sets session.code by its verdict; prints only notes and warnings. Throws Error,
// sequences::FileError, db::StoreError, analysis::AnalysisError.
WrittenReport write_reports(ReportOptions options, Session& session);

}  // namespace tactbench::bench
