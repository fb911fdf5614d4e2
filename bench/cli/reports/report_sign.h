// Checks before a report is signed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/signed_reports.h"
#include "db/record.h"

namespace tactbench::bench {

// To be called before `by` signs the report of run `run`. If there is no verdict, asks on a terminal; without a
// terminal requires `without_verdict` (TB-REPORT-NO-VERDICT). A verdict other than pass is reported on standard error.
void check_signature(const analysis::Judgement& judgement, std::int64_t run, const std::string& origin,
                     bool without_verdict, const Session& session);

// `before`: signed reports of the run, oldest first; `number`: the report to be written; `signing`: whether it is to be
// signed. Throws TB-REPORT-REASON if it would replace a signed report without a `reason`, or if there is a reason but
// nothing to replace.
void check_reason(const std::vector<db::ReportRecord>& before, const std::string& number, const std::string& reason,
                  bool signing);

// Writes FILE.p7s next to files of reports that are signed in the store, and prints that. Throws TB-REPORT-KEY, also
// for any other file.
void sign_files(const std::vector<std::string>& files, const SignerFiles& signer, const Session& session);

// The line in a run's notes that records the hash of a file of a signed report, without its date.
std::string report_file_note(const std::string& number, const std::string& sha256);

// Records the hash of a written file if report `number` is signed; a path that is not a regular file is skipped. A
// store that cannot be written is a warning.
void record_signed_file(const std::string& path, const std::string& number, std::int64_t run, const Session& session);

}  // namespace tactbench::bench
