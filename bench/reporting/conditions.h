// Under which conditions a judgement holds: the trajectories judged, the sources of uncertainty that dominate in use
// and that neither a judged run nor a budget covers, and a reference that was overdue.
#pragma once

#include <span>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"

namespace tactbench::bench {

// Fills in `trajectories`, `not_assessed` and `overdue` of `notes`, of the runs that `verdicts` are on. A source counts
// as assessed when a judged run shows it (mounted anew, at another temperature, a day or more apart, on another
// trajectory than the fitted one) or when `inputs`, the report's budgets, hold it; null: no budgets. `instruments`: of
// a laboratory file.
void note_conditions(analysis::Runs& runs, const analysis::SensorModel& fit,
                     std::span<const db::VerdictRecord> verdicts, const analysis::UncertaintyInputs* inputs,
                     const std::vector<analysis::InstrumentNote>& instruments, analysis::JudgementNotes& notes);

}  // namespace tactbench::bench
