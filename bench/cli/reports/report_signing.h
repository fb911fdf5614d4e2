// Checks before a report is signed.
#pragma once

#include <string>

#include "bench/cli/session.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

// To be called before `by` signs the report of run `run`: without a verdict asks on a terminal, and without a terminal
// requires `without_verdict` (TB-REPORT-NO-VERDICT); a verdict other than pass is reported on standard error.
void check_signature(const Judgement& judgement, std::int64_t run, const std::string& origin, bool without_verdict,
                     const Session& session);

}  // namespace tactbench::bench
