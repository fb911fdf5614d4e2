// Computes the figures of an evaluated run that limits can be set for, each with its U.
#pragma once

#include <optional>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

// Results of the models' run that several judged runs share, computed when the first one needs them.
struct OfModelsRun {
  std::optional<SweepErrors> sweeps;               // outputs rising
  std::optional<std::vector<Evaluation>> repeats;  // each by itself
};

// All but kMpe (mpe.h), kMismatch on every level in both directions. `evaluation` is that of `judged`, `reference` is
// the one of its run. U by criterion:
//   kMeanError, kWorstTaxelError   a common error of the reference moves them by at most itself (triangle inequality):
//                                  c = 1, not known without a certificate. Scatter: of a taxel from repeat to repeat,
//                                  pooled over the taxels, / sqrt(repeats)
//   kDistanceOfMean                the reference's error cancels in differences at one level. Scatter: of the array's
//                                  mean from full sweep to full sweep, pooled over the levels
//   kMismatch                      likewise; scatter of the figure from full sweep to full sweep
//   kUnfitTaxels                   a count by rule: U = 0
// Pooling (pooled_scatter.h) states its own degrees of freedom (JCGM 100, H.3.6). The scatter is that of `judged`, or
// of `models` (the run that they were made from) where `judged` has one repeat, or one full sweep. Throws as
// evaluate().
std::vector<Figure> measured_figures(const Dataset& judged, const Dataset& models, const SensorModel& fit,
                                     const Evaluation& evaluation, const ReferenceUncertainty& reference,
                                     int threads = 0, OfModelsRun* shared = nullptr);

}  // namespace tactbench::analysis
