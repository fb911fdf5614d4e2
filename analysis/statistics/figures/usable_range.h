// The range where the inverse of a taxel's external loop is well-conditioned: flat parts of a loop limit the useful
// range for a given resolution (paper, 6.1).
#pragma once

#include <vector>

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Resolved: an output off by in_noises standard deviations of a sample's noise moves the inverse's pressure by at most
// most_psi (the compensator's own criterion of a flat place). Usable: the same for an output off by the root sum of
// squares of that and the taxel's mean model error. The inverse is clamped to the range, so its ends look better.
struct UsableOptions {
  double in_noises = 4.0;
  double most_psi = 2.0;
  double least_share = 0.95;  // of the fitted taxels: a level with fewer is not in the range
};

struct UsableBranch {
  // Of each level: shares of the fitted taxels, and the pressure by which the usable criterion's output is off, of the
  // median and of the worst taxel.
  std::vector<double> resolved_share, usable_share, median_psi, worst_psi;
  // The longest row of levels with at least least_share of usable taxels; NaN when there is none.
  double low_psi = 0.0, high_psi = 0.0;
  double resolved_low_psi = 0.0, resolved_high_psi = 0.0;
};

struct UsableRange {
  UsableOptions options;
  std::vector<double> pressure_psi;  // grid of the models
  UsableBranch loading, unloading;   // along the patterns
  int taxels = 0;                    // fitted
};

UsableRange usable_range(const SensorModel& fit, const UsableOptions& options = {});

}  // namespace tactbench::analysis
