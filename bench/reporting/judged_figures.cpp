#include "bench/reporting/judged_figures.h"

#include <iterator>

#include "analysis/judgement/measured_figures.h"
#include "analysis/judgement/mpe.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/reporting/report_budget.h"

namespace tactbench::bench {

std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference) {
  const analysis::Dataset &judged = runs.dataset(evaluation.run), &models = runs.dataset(fit.run);
  std::vector<analysis::Figure> figures = analysis::measured_figures(judged, models, fit, evaluation, reference);
  if (limits.mpe.empty()) return figures;
  analysis::UncertaintyInputs inputs;
  inputs.history = held_out_histories(runs, fit.run, {evaluation.run});
  const analysis::Uncertainty readings = analysis::assess_uncertainty(models, fit, runs.record(fit.run), inputs);
  std::ranges::move(analysis::judged_mpe(analysis::mpe_figures(judged, fit, &readings, limits.mpe)),
                    std::back_inserter(figures));
  return figures;
}

}  // namespace tactbench::bench
