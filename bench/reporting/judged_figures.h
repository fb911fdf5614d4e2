// Computes the figures of a run that judge() compares with limits, from datasets and uncertainty budgets.
#pragma once

#include <vector>

#include "analysis/judgement/figure.h"
#include "analysis/judgement/measured_figures.h"
#include "analysis/report/runs.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::bench {

// `of_models`: of the models' run, filled in by the first call and shared by further ones with the same `fit`. Of
// `evaluation`, with the models of `fit`; `reference` is that of its run. One of each [[mpe]] of the limits. U of a
// reading is counted on the judged run alone, so that stored verdicts do not depend on a report's further runs.
std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference,
                                             analysis::OfModelsRun& of_models);

}  // namespace tactbench::bench
