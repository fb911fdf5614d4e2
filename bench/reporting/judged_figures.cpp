#include "bench/reporting/judged_figures.h"

#include <iterator>

#include "analysis/judgement/measured_figures.h"
#include "analysis/judgement/mpe.h"
#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::bench {

std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference) {
  const analysis::Dataset &judged = runs.dataset(evaluation.run), &models = runs.dataset(fit.run);
  std::vector<analysis::Figure> figures = analysis::measured_figures(judged, models, fit, evaluation, reference);
  if (limits.mpe.empty()) return figures;
  const analysis::Uncertainty readings = analysis::assess_uncertainty(models, fit, runs.record(fit.run));
  // Without a certificate no budget is complete.
  const std::string& missing = readings.reference.certificate_missing;
  std::ranges::move(analysis::judged_mpe(
                        analysis::mpe_figures(judged, fit, missing.empty() ? &readings : nullptr, limits.mpe), missing),
                    std::back_inserter(figures));
  return figures;
}

}  // namespace tactbench::bench
