// Evaluates runs by number: fits, figures, stored results and reports; shared by fit, report and demo.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/gather.h"
#include "analysis/report/report.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/named_evaluation.h"
#include "bench/reporting/report_results.h"

namespace tactbench::bench {

// Build of this program and class of processor, stored with each fit: if both are equal, recomputed results are equal
// bit for bit. A modified build is marked, because two modified builds may differ.
std::string this_build();

// Stores the models and this program's build. Returns the fit's number.
std::int64_t keep_fit(db::RunStore& store, const analysis::SensorModel& fit);
// Fits ELAM to all taxels of a run's dataset and stores the models, for the control charts of nights and rig checks.
analysis::SensorModel fit_run(db::RunStore& store, const analysis::Dataset& dataset);
// The same with the dynamic model of that one run.
analysis::SensorModel fit_run_dynamic(db::RunStore& store, analysis::Runs& runs, std::int64_t run);

// The run's own figures with its stored fit, then those of `held_out` runs with the same models.
std::vector<NamedEvaluation> evaluate_runs(analysis::Runs& runs, const analysis::SensorModel& fit,
                                           const std::vector<std::int64_t>& held_out,
                                           const std::vector<std::string>& titles = {});

// Stores the figures of the fit on its own run `run` under "sensor/SERIAL/RECIPES", of the dynamic model under
// ".../dynamic", for trend and baselines; returns that subject; empty for an imported run, which has no sensor.
std::string record_sensor_trend(db::Models& store, const db::RunRecord& run, const analysis::SensorModel& fit,
                                const analysis::Evaluation& own);

// The figures of a stored fit of ELAM or the dynamic model, which may represent its run; other models have none.
void record_fit_trend(db::RunStore& store, const analysis::SensorModel& fit, const analysis::Evaluation& own);

// A report's input about `run`: models and figures if there are any, verdicts, and everything else stored.
// `evaluations` is empty, or the first is of the run itself and the others are of held-out runs. `extras` null: without
// model comparison, further studies and uncertainty, which take most of the time. With studies in the budgets the
// evidence of `judged` is judged again.
analysis::ReportInput report_input(analysis::Runs& runs, std::int64_t run, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const JudgementRecord& judged,
                                   const std::vector<std::int64_t>& further = {}, const ReportExtras* extras = nullptr);

// Renders the report of `evaluations` (the first is the fit's own run) into `path`, or reports/run-N.html next to the
// store. `replace`: also a file of another kind (output_file.h). Returns the path.
std::string write_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                         const std::vector<NamedEvaluation>& evaluations, const JudgementRecord& judged,
                         std::string path, std::string* number, const ReportExtras& extras = {}, bool replace = false);

// reports/NAME next to the store.
std::string report_path(const db::RunReader& store, const std::string& name);

}  // namespace tactbench::bench
