// The samples of a dataset in time order, and the creep along them.
#pragma once

#include <array>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/models/dynamics.h"

namespace tactbench::analysis {

struct Track {
  std::vector<double> time, pressure;
  std::vector<const Sample*> samples;
  double span = 0.0;                 // of the pressures
  std::vector<const double*> volts;  // row of taxels
  std::vector<std::size_t> sequence, repeat, step;
};
Track track_of(const Dataset& data);  // keeps pointers into `data`

// One sample further along a run: time that no command accounts for was conditioning over 0 to `span`. `before`: the
// time of the sample before, negative at the first.
DynamicsStep next_step(const Dynamics& d, DynamicsState& state, const Sample& sample, double before, double span);

// psi of each element at each sample.
std::vector<std::array<double, kCreepElements>> walk_creep(const Track& track, const Dynamics& d);

}  // namespace tactbench::analysis
