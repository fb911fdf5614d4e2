// Compares the typed role of a further run, "7:mount" or "4:90", with what that run itself records: its recipes, how
// the simulated sensor was mounted, and the metadata `turned` and `mount` of its operator.
#pragma once

#include "bench/reporting/report_results.h"
#include "db/record.h"

namespace tactbench::bench {

enum class StudyPurpose { kPlainLoops, kPresses, kPaces };  // by its recipes

// Throws Error TB-REPORT-STUDY where a record contradicts the role. Without such a record the typed role is accepted.
void check_role(const StudyRun& study, const db::RunRecord& own, const db::RunRecord& other, StudyPurpose purpose);

}  // namespace tactbench::bench
