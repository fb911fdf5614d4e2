// What has to be there before someone signs a report.
#pragma once

#include <string>

#include "bench/cli/session.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

// Before `by` signs for the report of run `run`: without a verdict a terminal is asked, and without a terminal
// `without_verdict` has to say so (TB-REPORT-NO-VERDICT); a verdict that is no pass is said on standard error.
void check_signature(const Judgement& judgement, std::int64_t run, const std::string& origin, bool without_verdict,
                     const Session& session);

}  // namespace tactbench::bench
