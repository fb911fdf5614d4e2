// How far compensated pressures are from the truth on the simulated sensors, the paper's and the harsh one: the dynamic
// compensator beside ELAM's stream, both identified on the same runs, on sensors and trajectories that nothing was
// chosen on.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "analysis/statistics/scoring/score.h"
#include "bench/benchmarks/figure.h"
#include "bench/benchmarks/simulated_run.h"

namespace tactbench::bench {

// Mean error in psi over all taxels and frames of all `sensor_seeds`; runs are made in `folder`. `all_models`: the
// others too, as they are and on the linearised output, by the one rule of comparison, every eighth taxel.
std::vector<Figure> benchmark_compensation_error(const std::vector<unsigned>& sensor_seeds, const std::string& folder,
                                                 bool all_models = false, const Simulate& simulate = simulate_run);

// The runs that both are tried on, by condition.
struct ConditionRun {
  std::string condition;
  SimulatedRun made;
};
std::vector<ConditionRun> compensation_error_runs();

struct CoveredErrors {
  analysis::ErrorSum error;
  double covered = 0.0;  // samples whose error is within twice the uncertainty
  void add(const CoveredErrors& other) {
    error.add(other.error);
    covered += other.covered;
  }
};

// Means of all sensors, by condition; `others` by condition and model.
struct ErrorsOfSpecimen {
  std::map<std::string, CoveredErrors> dynamic, alone, elam;  // alone: the dynamic model without lag and creep
  std::map<std::string, analysis::ErrorSum> others;
};
// Throws std::out_of_range when one of the conditions is missing.
void add_figures(FigureList& figures, const ErrorsOfSpecimen& errors, bool harsh);

}  // namespace tactbench::bench
