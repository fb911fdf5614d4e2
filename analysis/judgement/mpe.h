// The reading of a taxel against a maximum permissible error (MPE): at each level of a span, going up and going down,
// the mean error of the judged run's frames there, and U of one reading from the uncertainty budgets.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/figures/limits.h"
#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::analysis {

// Of one [[mpe]]. The share of taxels s.t. |error| <= MPE is at least `share` exactly when value_psi <= MPE, and
// likewise for |error| + U and value_psi + expanded_psi: both are quantiles over the fitted taxels of the largest over
// the levels.
struct MpeFigure {
  Scope scope;
  double value_psi = 0.0;     // NaN: no level of the span was measured
  double expanded_psi = 0.0;  // NaN: without budgets
  int levels = 0;             // measured within the span
};

Scope scope_of(const Limits::Mpe& mpe);

// `readings`: the budgets of the models' run, of the same taxels; null: U is not known. At a level without budgets the
// nearest ones of its branch count, the larger of two. Throws as evaluate().
std::vector<MpeFigure> mpe_figures(const Dataset& judged, const SensorModel& fit, const Uncertainty* readings,
                                   std::span<const Limits::Mpe> limits, int threads = 0);

// As judge() asks for them. `missing`: why no U is known; empty: it may be.
std::vector<Figure> judged_mpe(std::span<const MpeFigure> figures, const std::string& missing = {});

}  // namespace tactbench::analysis
