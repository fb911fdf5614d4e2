// From run numbers to figures: what fit, report and demo do alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

// Build and class of processor of this program, kept with each fit: where both are the same, recomputed results have
// the same bits. A modified build says so: two of them need not be the same.
std::string this_build();

// Fits all taxels of `run` and stores the models.
analysis::ArrayFit fit_run(db::RunStore& store, std::int64_t run);

// The run's own figures with its stored fit, then those of `held_out` runs with the same models.
std::vector<NamedEvaluation> evaluate_runs(const db::RunStore& store, const analysis::ArrayFit& fit,
                                           const std::vector<std::int64_t>& held_out,
                                           const std::vector<std::string>& titles = {});

// What limits are judged on: the first held-out run, whose frames no model has seen, else the fit's own run.
const analysis::Evaluation& judged(const std::vector<NamedEvaluation>& evaluations);

// Judges by the limits and stores the verdicts.
std::vector<db::VerdictRecord> judge_and_store(db::RunStore& store, const analysis::ArrayFit& fit,
                                               const analysis::Evaluation& evaluation, const std::string& limits_file);

// Keeps the figures of the fit on its own run under "sensor/SERIAL/RECIPES", for trend and baselines; returns that
// subject, empty for an imported run, which has no sensor.
std::string follow_sensor(db::RunStore& store, const analysis::ArrayFit& fit, const analysis::Evaluation& own);

// What a report says of `run`: models and figures where there are any, verdicts, everything else from the store.
// `evaluations` is empty, or its first is the run's own and the others are held out.
analysis::ReportInput report_input(const db::RunStore& store, std::int64_t run, const analysis::ArrayFit& fit,
                                   const std::vector<NamedEvaluation>& evaluations,
                                   const std::vector<db::VerdictRecord>& verdicts,
                                   const std::vector<std::int64_t>& further = {});

// Renders the report of `evaluations` (the first is the fit's own run) into `path`, or reports/run-N.html next to the
// store. Returns the path.
std::string write_report(const db::RunStore& store, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations,
                         const std::vector<db::VerdictRecord>& verdicts, std::string path, std::string* number);

// reports/NAME beside the store.
std::string report_path(const db::RunStore& store, const std::string& name);

}  // namespace tactbench::bench
