// From run numbers to figures: what fit, report and demo do alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/statistics/verdict.h"
#include "bench/cli/named_evaluation.h"
#include "bench/cli/report_results.h"
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

// U of what limits are held against; the datasets are read from the store.
std::vector<analysis::JudgedUncertainty> uncertainties_of(const db::RunStore& store, const analysis::ArrayFit& fit,
                                                          const analysis::Evaluation& evaluation);

// Judges by the limits, stores nothing. With U where the rule asks for it.
std::vector<db::VerdictRecord> judge_anew(const db::RunStore& store, const analysis::ArrayFit& fit,
                                          const analysis::Evaluation& evaluation, const analysis::Limits& limits);

// On standard error: how many criteria pass or fail only conditionally.
void warn_of_conditional(const std::vector<db::VerdictRecord>& verdicts);

// Judges by the limits and stores the verdicts; of a report-only file none are stored.
std::vector<db::VerdictRecord> judge_and_store(db::RunStore& store, const analysis::ArrayFit& fit,
                                               const analysis::Evaluation& evaluation, const std::string& limits_file);

// Keeps the figures of the fit on its own run under "sensor/SERIAL/RECIPES", for trend and baselines; returns that
// subject, empty for an imported run, which has no sensor.
std::string follow_sensor(db::RunStore& store, const analysis::ArrayFit& fit, const analysis::Evaluation& own);

// Fills in `uncertainty` of a reading, and `judged`: U of the figures in `input.verdicts`, which must stand there.
void add_uncertainty(const db::RunStore& store, const analysis::ArrayFit& fit,
                     const std::vector<NamedEvaluation>& evaluations, analysis::ReportInput& input,
                     const analysis::UncertaintyInputs& inputs = {});
// What a report says of `run`: models and figures where there are any, verdicts, everything else from the store.
// `evaluations` is empty, or its first is the run's own and the others are held out.
// `extras` null: without models compared, further studies and uncertainty, which cost most.
analysis::ReportInput report_input(const db::RunStore& store, std::int64_t run, const analysis::ArrayFit& fit,
                                   const std::vector<NamedEvaluation>& evaluations,
                                   const std::vector<db::VerdictRecord>& verdicts,
                                   const std::vector<std::int64_t>& further = {}, const ReportExtras* extras = nullptr);

// Renders the report of `evaluations` (the first is the fit's own run) into `path`, or reports/run-N.html next to the
// store. Returns the path.
std::string write_report(const db::RunStore& store, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations,
                         const std::vector<db::VerdictRecord>& verdicts, std::string path, std::string* number,
                         const ReportExtras& extras = {});

// reports/NAME beside the store.
std::string report_path(const db::RunStore& store, const std::string& name);

}  // namespace tactbench::bench
