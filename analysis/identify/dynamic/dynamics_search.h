// Lag and creep of an array: from runs that vary time (recipes `rate` and `creep-levels`; no static model is needed),
// or from the run that the models are fitted on: where it passes the same levels repeatedly the output rises from pass
// to pass.
#pragma once

#include <array>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
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

// Misfit of one Preisach model of the array's mean, on the linearised output with the creep of `d` removed.
class CreepMisfit {
 public:
  // `zero_v`, `usable`: per taxel. `fit`: as the models are fitted. Pressures from 0 to `highest`.
  CreepMisfit(const Dataset& fitted, const std::vector<double>& zero_v, const std::vector<bool>& usable, double highest,
              const FitOptions& fit);
  // Sum of squares over the square of the full output; infinite where no model can be fitted.
  [[nodiscard]] double operator()(const Dynamics& d) const;
  // Slowest relaxation times to try, seconds: some within half of the run; none where it tells no times.
  [[nodiscard]] const std::vector<double>& slowest_s() const { return slowest_s_; }

 private:
  Dataset mean_;
  double zero_v_ = 0.0, highest_;
  FitOptions fit_;
  std::vector<double> slowest_s_;
};

inline constexpr double kFastest = 3.0;  // seconds
// Relaxation times evenly spaced over the logarithm of time, the slowest as given.
std::array<double, kCreepElements> creep_times(double slowest_s, double fastest_s = kFastest);

// One share for all relaxation times, a straight line over the logarithm of time: one dwell tells no more. Share and
// slowest time are those of the least misfit; none (0) where creep does not explain a good part of it.
Dynamics creep_of_one_run(const CreepMisfit& misfit);

// Creep of one share and lag of a recording with inputs from 0 to `highest`, samples `step_s` apart: in turn, each
// where it explains a good part of the misfit that the other leaves.
Dynamics dynamics_of_recording(const CreepMisfit& misfit, double highest, double step_s, double longest_s);

// The outputs of a run with lag and creep removed, at the pressures that have arrived.
Dataset dataset_without_dynamics(Dataset data, const ArrayDynamics& dynamics, const std::vector<double>& zero_v,
                                 double span);

// The samples of a dataset in time order, and the creep along them.
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
