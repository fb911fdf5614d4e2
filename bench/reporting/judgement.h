// Judges stored runs (analysis/judgement/judgement.h), stores the verdicts, and finds the verdict that is valid for a
// run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/judgement/figure.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/reporting/evidence.h"

namespace tactbench::bench {

// A judgement with its input; the evidence is empty if the judgement was stored.
struct JudgementRecord {
  analysis::Evidence evidence;
  analysis::Limits limits;
  analysis::Judgement judgement;
};

// Judges by a limits file and stores the verdicts with the fit; for a report-only file stores nothing. `store`: the
// store of `runs`. Worse stored verdicts by other limits are reported.
JudgementRecord judge_and_store(db::RunStore& store, analysis::Runs& runs, const analysis::SensorModel& fit,
                                const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                                bool void_too = false, const std::vector<analysis::InstrumentNote>& notes = {});

// For `report`: judges by `limits_file`, else by the limits last used for these models; otherwise does not judge.
// Stores nothing.
JudgementRecord judge_for_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                                 const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                                 bool void_too, const std::vector<analysis::InstrumentNote>& notes,
                                 const StoredVerdicts& stored);

// The stored verdicts on a run without models: the newest judgement, and worse ones.
analysis::Judgement judgement_on(const db::RunStore& store, std::int64_t run);

// The verdicts that are valid for a run.
struct Standing {
  // All valid stored verdicts of a run: on the run itself, and on any run by models made from it. Verdicts on the runs
  // from which the models were made are inconclusive and count only if there are no others. None for a void run, and
  // none by models that are based on a void run.
  std::vector<analysis::JudgedFigure> figures;
  std::optional<analysis::Verdict> verdict;  // fail if any of them is fail, else the worst by the newest limits
  bool rests_on_means_alone = false;         // the verdict is pass, and none of the limits applies to single readings
  // The run whose models gave the newest verdict; 0: none.
  [[nodiscard]] std::int64_t models_run() const { return figures.empty() ? 0 : figures.back().model_run; }
  // The figure that decides the verdict: among those with that verdict, the one furthest beyond its limit or closest to
  // it; null without a verdict.
  [[nodiscard]] const analysis::JudgedFigure* deciding() const;
};
Standing standing(const db::RunStore& store, std::int64_t run);
// The run whose report covers this one: the run of the models by which it was judged, else itself if it has models; 0:
// neither.
std::int64_t reporting_run(const db::Models& store, const Standing& of, std::int64_t run);

// Computes the figures of a run that judge() compares with limits, from datasets and uncertainty budgets.

// Figures of `evaluation` with the models of `fit`; `reference` is the reference of its run. `of_models`: data of the
// models' run, filled in by the first call and reused by later calls with the same `fit`. One figure per [[mpe]] of the
// limits. U of a reading is computed from the judged run alone, so that stored verdicts do not depend on a report's
// further runs.
std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference,
                                             analysis::ModelRunResults& of_models);

}  // namespace tactbench::bench
