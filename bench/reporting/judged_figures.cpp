#include "bench/reporting/judged_figures.h"

#include <optional>

#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::bench {

JudgedFigures judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                             const analysis::ReferenceUncertainty& reference) {
  JudgedFigures figures;
  const bool needed = analysis::needs_uncertainty(limits.rule);
  const analysis::Dataset &judged = runs.dataset(evaluation.run), &models = runs.dataset(fit.run);
  if (needed) figures.uncertainties = analysis::judged_uncertainties(judged, models, fit, evaluation, reference);
  if (limits.mpe.empty()) return figures;
  std::optional<analysis::Uncertainty> readings;
  if (needed) readings = analysis::assess_uncertainty(models, fit, runs.record(fit.run));
  // Without a certificate no budget is complete.
  const bool known = readings && readings->reference.certificate_missing.empty();
  figures.mpe = analysis::mpe_figures(judged, fit, known ? &*readings : nullptr, limits.mpe);
  if (needed)
    for (analysis::JudgedUncertainty& own : analysis::mpe_uncertainties(figures.mpe, evaluation.run)) {
      if (!known) own.missing = readings->reference.certificate_missing;
      figures.uncertainties.push_back(std::move(own));
    }
  return figures;
}

}  // namespace tactbench::bench
