// From run numbers to figures: what fit, report and demo do alike.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"
#include "analysis/statistics/conformity/verdict.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/named_evaluation.h"
#include "bench/reporting/report_results.h"

namespace tactbench::bench {

// Build and class of processor of this program, kept with each fit: where both are the same, recomputed results have
// the same bits. A modified build says so: two of them need not be the same.
std::string this_build();

// Stores the models, with this program's build.
void keep_fit(db::RunStore& store, const analysis::ArrayFit& fit);
// Fits all taxels of a run's dataset and stores the models.
analysis::ArrayFit fit_run(db::RunStore& store, const analysis::Dataset& dataset);

// The run's own figures with its stored fit, then those of `held_out` runs with the same models.
std::vector<NamedEvaluation> evaluate_runs(analysis::Runs& runs, const analysis::ArrayFit& fit,
                                           const std::vector<std::int64_t>& held_out,
                                           const std::vector<std::string>& titles = {});

// What rests on a reference that was overdue when its run was made, by what the run stored or by a laboratory file's
// `notes`, becomes inconclusive. Returns a sentence for each such run.
std::vector<std::string> withhold_overdue_runs(analysis::Runs& runs, std::vector<db::VerdictRecord>& verdicts,
                                               const std::vector<analysis::InstrumentNote>& notes);

// On standard error: how many criteria pass or fail only conditionally.
void warn_of_conditional(const std::vector<db::VerdictRecord>& verdicts);

// Keeps the figures of the fit on its own run `run` under "sensor/SERIAL/RECIPES", for trend and baselines; returns
// that subject, empty for an imported run, which has no sensor.
std::string follow_sensor(db::RunStore& store, const db::RunRecord& run, const analysis::ArrayFit& fit,
                          const analysis::Evaluation& own);

// Fills in `uncertainty` of a reading, and `judged`: U of the figures in `input.verdicts`, which must stand there.
// `known`: what of it was found when they were judged.
void add_uncertainty(analysis::Runs& runs, const analysis::ArrayFit& fit,
                     const std::vector<NamedEvaluation>& evaluations, analysis::ReportInput& input,
                     const analysis::UncertaintyInputs& inputs = {},
                     std::vector<analysis::JudgedUncertainty> known = {});
// What a report says of `run`: models and figures where there are any, verdicts, everything else that is stored.
// `evaluations` is empty, or its first is the run's own and the others are held out.
// `extras` null: without models compared, further studies and uncertainty, which cost most.
analysis::ReportInput report_input(analysis::Runs& runs, std::int64_t run, const analysis::ArrayFit& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const Judgement& judgement,
                                   const std::vector<std::int64_t>& further = {}, const ReportExtras* extras = nullptr);

// Renders the report of `evaluations` (the first is the fit's own run) into `path`, or reports/run-N.html next to the
// store. `replace`: a file of another kind (output_file.h). Returns the path.
std::string write_report(analysis::Runs& runs, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations, const Judgement& judgement, std::string path,
                         std::string* number, const ReportExtras& extras = {}, bool replace = false);

// reports/NAME beside the store.
std::string report_path(const db::RunStore& store, const std::string& name);

}  // namespace tactbench::bench
