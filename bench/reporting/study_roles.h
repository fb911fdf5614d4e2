// Compares the typed role of a further run, "7:mount" or "4:90", with the run's own record: its recipes, how the
// simulated sensor was mounted, and the operator's metadata `turned` and `mount`.
#pragma once

#include <string>
#include <vector>

#include "bench/reporting/report_results.h"
#include "db/record.h"

namespace tactbench::bench {

enum class StudyPurpose { kPlainLoops, kPresses, kPaces };  // by its recipes

// Throws Error TB-REPORT-STUDY where a record contradicts the role. Without such a record the typed role is accepted.
void check_role(const StudyRun& study, const db::RunRecord& own, const db::RunRecord& other, StudyPurpose purpose);

// Describes how each sequence of a run was measured, from its recipe and the overridden values.

// In the order of the run's sequences: "3 repeats of 2 sweeps; a level every 4 psi, from 0 to 60 to 0 psi; waiting time
// (dwell) 1 s ...". Pressures in psi and kPa. Empty if the recipe can no longer be read.
std::vector<std::string> method_descriptions(const db::RunRecord& run);

}  // namespace tactbench::bench
