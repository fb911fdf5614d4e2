// The reading of a taxel against a maximum permissible error (MPE): at each level of a span, going up and going down,
// the mean error of the judged run's frames there, and |known error| + U of one reading, the largest over the kinds of
// history that the run went through and U is valid for.
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
  double expanded_psi = 0.0;  // NaN: not known
  int levels = 0;             // measured within the span
  std::string kinds;          // of history whose U counts, in words: "full sweeps; held pressures (up to 20 s)"
  std::string not_known;      // why expanded_psi is not
  std::vector<UseCondition> counted = {};  // the kinds, and other states, of `kinds`
};

Scope scope_of(const Limits::Mpe& mpe);

// `readings`: U of the sensor's readings, those of its conditions that rest on the judged run count; null: not known. U
// is not known where none is valid, or none says anything of a level of the span. Throws as evaluate().
std::vector<MpeFigure> mpe_figures(const Dataset& judged, const SensorModel& fit, const Uncertainty* readings,
                                   std::span<const Limits::Mpe> limits, int threads = 0);

// As judge() asks for them.
std::vector<Figure> judged_mpe(std::span<const MpeFigure> figures);

}  // namespace tactbench::analysis
