// Checks before a report is signed.
#pragma once

#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/signature.h"
#include "db/record.h"

namespace tactbench::bench {

// To be called before `by` signs the report of run `run`: without a verdict asks on a terminal, and without a terminal
// requires `without_verdict` (TB-REPORT-NO-VERDICT); a verdict other than pass is reported on standard error.
void check_signature(const analysis::Judgement& judgement, std::int64_t run, const std::string& origin,
                     bool without_verdict, const Session& session);

// `before`: signed reports of the run, oldest first; `number`: the one to be written, `signing` whether to be signed.
// Throws TB-REPORT-REASON where it would be signed in place of another without a `reason`, and where there is a reason
// and nothing to replace.
void check_reason(const std::vector<db::ReportRecord>& before, const std::string& number, const std::string& reason,
                  bool signing);

// Writes FILE.p7s beside files of reports that are signed in the store, and tells so. Throws TB-REPORT-KEY, also for a
// file of any other kind.
void sign_files(const std::vector<std::string>& files, const SignerFiles& signer, const Session& session);

}  // namespace tactbench::bench
