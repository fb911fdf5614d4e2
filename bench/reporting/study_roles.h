// The role of a further run as typed, "7:mount" or "4:90", held against what that run itself records: its recipes, how
// the simulated sensor lay, and the metadata `turned` and `mount` of its operator.
#pragma once

#include "bench/reporting/report_results.h"
#include "db/record.h"

namespace tactbench::bench {

enum class StudyPurpose { kPlainLoops, kPresses, kPaces };  // by its recipes

// Throws Error TB-REPORT-STUDY where a record contradicts the role. A run without such a record is believed.
void check_role(const StudyRun& study, const db::RunRecord& own, const db::RunRecord& other, StudyPurpose purpose);

}  // namespace tactbench::bench
