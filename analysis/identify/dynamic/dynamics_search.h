// Lag and creep of an array from runs that vary time: recipes `rate` and `creep-levels`. No static model is needed.
#pragma once

#include <vector>

#include "analysis/dataset.h"
#include "analysis/models/dynamics.h"

namespace tactbench::analysis {

struct ArrayDynamics {
  Dynamics shared;
  // Per taxel: its creep over the array's, and its share that comes late. Drawn toward the array's where they are
  // uncertain.
  std::vector<double> creep_scale, lag_share;
  int holds = 0, rate_samples = 0;  // that were used
};

// `zero_v` and `usable` are per taxel. Creep: within each held level of `creep` the static output is constant, so that
// the outputs' relative change is linear in the shares; half by search. Lag: repeats of `rate` differ by the slope
// times what has not arrived; its time by search. Without a run (null) its part is 0. Levels that are held for less
// than 10 samples show nothing about creep, a rate run with one dwell nothing about the lag.
ArrayDynamics find_dynamics(const Dataset* rate, const Dataset* creep, const std::vector<double>& zero_v,
                            const std::vector<bool>& usable);

// Their parts.
void find_creep(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                ArrayDynamics& result);
// Of creep that is known, the taxels' scales alone.
void find_creep_scales(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                       ArrayDynamics& result);
void find_lag(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
              ArrayDynamics& result);  // creep is known

}  // namespace tactbench::analysis
