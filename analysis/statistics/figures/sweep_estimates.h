// Compensated pressures of an array at each level of each full loading sweep; used to compare runs of one sensor.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

struct SweepEstimates {
  std::vector<double> pressure_psi;  // levels: set-points of a full sweep, ascending
  int sweeps = 0, taxels = 0;
  // levels x sweeps x taxels: estimates moved to the set-point (1 psi/psi x (set-point - reference)); NaN where a taxel
  // is not fitted.
  std::vector<double> psi;
  [[nodiscard]] double at(std::size_t level, int sweep, int taxel) const {
    return psi[(level * static_cast<std::size_t>(sweeps) + static_cast<std::size_t>(sweep)) *
                   static_cast<std::size_t>(taxels) +
               static_cast<std::size_t>(taxel)];
  }
  [[nodiscard]] double mean(std::size_t level, int taxel) const;  // over the sweeps
};

// Every frame of every repeat in time order through the compensator; sweeps from the lowest to the highest set-point of
// `fit`'s range are kept, of those with the levels of the first. Throws AnalysisError TB-ANALYSIS-OTHER-SENSOR and
// TB-ANALYSIS-ORIGIN as evaluate() does, TB-ANALYSIS-NO-LOOP when there is no full sweep.
SweepEstimates sweep_estimates(const Dataset& dataset, const SensorModel& fit, int threads = 0);

}  // namespace tactbench::analysis
