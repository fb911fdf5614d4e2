// What a report says of a run beside models, figures and verdicts: runs -> ReportInput.
#pragma once

#include "analysis/report/report.h"
#include "analysis/report/runs.h"

namespace tactbench::analysis {

// Fills in run, sensor, frame_count, history, health, behaviour (also creep of the further runs) and approvals of run
// `run`; fit and evaluation must stand in `input` already where there are any. Throws StoreError, AnalysisError.
void gather_run(ReportInput& input, Runs& runs, std::int64_t run, const std::vector<std::int64_t>& further = {});

// The taxels that raw figures count: those with a model, without models those that health finds fit to use.
std::vector<int> counted_taxels(const ArrayFit& fit, const Health& health);

}  // namespace tactbench::analysis
