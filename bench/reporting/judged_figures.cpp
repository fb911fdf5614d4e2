#include "bench/reporting/judged_figures.h"

#include <iterator>

#include "analysis/judgement/mpe.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/reporting/report_budget.h"

namespace tactbench::bench {

std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference,
                                             analysis::OfModelsRun& of_models) {
  const analysis::Dataset &judged = runs.dataset(evaluation.run), &models = runs.dataset(fit.run);
  std::vector<analysis::Figure> figures =
      analysis::measured_figures(judged, models, fit, evaluation, reference, 0, &of_models);
  if (limits.mpe.empty()) return figures;
  if (!of_models.sweeps) {
    analysis::SensorModel rising = fit;
    const analysis::Dataset turned = analysis::as_modelled(models, rising);
    rising.falling = false;
    of_models.sweeps = analysis::sweep_errors(turned, rising);
  }
  analysis::Uncertainty readings;
  readings.conditions = analysis::reading_conditions(
      models, fit, runs.record(fit.run), held_out_histories(runs, fit.run, {evaluation.run}), *of_models.sweeps);
  std::ranges::move(analysis::judged_mpe(analysis::mpe_figures(judged, fit, &readings, limits.mpe)),
                    std::back_inserter(figures));
  return figures;
}

}  // namespace tactbench::bench
