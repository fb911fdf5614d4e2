// Compares a taxel's reading with a maximum permissible error (MPE): at each level of a span, in both directions, the
// mean error of the judged run's frames, and |known error| + U of one reading, the largest over the kinds of history
// that occur in the run and for which U is valid.
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

// Result for one [[mpe]]. At least `share` of the taxels have |error| <= MPE exactly if value_psi <= MPE; the same
// holds for |error| + U and value_psi + expanded_psi. Both are quantiles over the fitted taxels of the maximum over the
// levels.
struct MpeFigure {
  Scope scope;
  double value_psi = 0.0;     // NaN: no level of the span was measured
  double expanded_psi = 0.0;  // NaN: not known
  int levels = 0;             // number of levels measured within the span
  std::string kinds;      // kinds of history for which U was used, as text: "full sweeps; held pressures (up to 20 s)"
  std::string not_known;  // why expanded_psi is not known
  std::vector<UseCondition> counted = {};  // the kinds, and other states, of `kinds`
};

Scope scope_of(const Limits::Mpe& mpe);

// `readings`: U of the sensor's readings, of which only conditions derived from the judged run are used; null: not
// known. U is not known if no condition is valid, or if none covers a level of the span. Throws as evaluate().
std::vector<MpeFigure> mpe_figures(const Dataset& judged, const SensorModel& fit, const Uncertainty* readings,
                                   std::span<const Limits::Mpe> limits, int threads = 0);

// The figures in the form that judge() needs.
std::vector<Figure> judged_mpe(std::span<const MpeFigure> figures);

}  // namespace tactbench::analysis
