// Collects a report's input from a run, apart from models, figures and verdicts.
#pragma once

#include "analysis/report/report.h"
#include "analysis/report/runs.h"

namespace tactbench::analysis {

// Fills in run, sensor, frame_count, history, health, behaviour (also creep of the further runs) and approvals of run
// `run`; fit and evaluation, if any, must be in `input` before. Throws StoreError, AnalysisError.
void gather_run(ReportInput& input, Runs& runs, std::int64_t run, const std::vector<std::int64_t>& further = {});

// The taxels of raw figures: those with a model; without models those that the health check accepts.
std::vector<int> counted_taxels(const SensorModel& fit, const Health& health);

}  // namespace tactbench::analysis
