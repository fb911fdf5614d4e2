// Time-dependent behaviour of a film: a share of the pressure arrives late (lag), and the output creeps toward the
// value that belongs to the present pressure. The times are those of the array, the size of both effects is each
// taxel's. Both are compensated sample by sample.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace tactbench::analysis {

inline constexpr std::size_t kCreepElements = 3;

// The most that creep may take of an output: what is left is divided by.
inline constexpr double kMaxCreep = 0.9, kMaxCreepScale = 10.0;

struct Dynamics {
  // v = (1 + sum k_j (psi_j - 1)) * static output, psi_j' = (h(p) - psi_j) / tau_j, h(p) = p / (p + half), p counted
  // from the lowest pressure.
  std::array<double, kCreepElements> creep_s = {3.0, 30.0, 300.0};
  std::array<double, kCreepElements> creep_share = {0.0, 0.0, 0.0};
  double creep_half = 10.0;
  // arrived = (1 - share) p + share l, l' = (p - l) / lag_s.
  double lag_s = 1.0, lag_share = 0.0;
};

// Whether a compensator has lag or creep to remove, and needs the times of the samples.
inline bool undoes(const Dynamics& d) {
  return d.lag_share != 0.0 || d.creep_share != std::array<double, kCreepElements>{};
}

// One taxel's, along its samples: the input is taken as having gone to its value right after the sample before.
struct DynamicsState {
  std::array<double, kCreepElements> psi = {0.0, 0.0, 0.0};
  double late = 0.0;  // l
};

// What remains of a state after a time; the same for all taxels.
struct DynamicsStep {
  std::array<double, kCreepElements> creep = {1.0, 1.0, 1.0};
  double lag = 1.0;
  DynamicsStep() = default;
  DynamicsStep(const Dynamics& d, double seconds) : lag(std::exp(-seconds / d.lag_s)) {
    for (std::size_t j = 0; j < kCreepElements; ++j) creep[j] = std::exp(-seconds / d.creep_s[j]);
  }
};

inline double creep_target(const Dynamics& d, double pressure) {
  const double p = pressure > 0.0 ? pressure : 0.0;
  return p / (p + d.creep_half);
}
// Of the output, when the pressure has been `pressure` since the sample before. `scale`: this taxel's creep over the
// array's.
inline double creep_factor(const Dynamics& d, const DynamicsState& state, const DynamicsStep& step, double pressure,
                           double scale) {
  const double target = creep_target(d, pressure);
  double sum = 0.0;
  for (std::size_t j = 0; j < kCreepElements; ++j)
    sum += d.creep_share[j] * (target + (state.psi[j] - target) * step.creep[j] - 1.0);
  return 1.0 + scale * sum;
}
// The pressure that has arrived, and the one that it came from. `share`: this taxel's.
inline double arrived(double share, const DynamicsState& state, const DynamicsStep& step, double pressure) {
  return pressure + share * step.lag * (state.late - pressure);
}
inline double before_lag(double share, const DynamicsState& state, const DynamicsStep& step, double arrived_pressure) {
  const double left = share * step.lag;
  return (arrived_pressure - left * state.late) / (1.0 - left);
}
inline void advance(const Dynamics& d, DynamicsState& state, const DynamicsStep& step, double pressure) {
  const double target = creep_target(d, pressure);
  for (std::size_t j = 0; j < kCreepElements; ++j) state.psi[j] = target + (state.psi[j] - target) * step.creep[j];
  state.late = pressure + (state.late - pressure) * step.lag;
}

// Advances the state by a time in which the pressure cycled unmeasured over 0 to `span` (conditioning), and came to
// rest at 0.
inline void work_unseen(const Dynamics& d, DynamicsState& state, double seconds, double span) {
  const double target = 1.0 - d.creep_half / span * std::log1p(span / d.creep_half);  // the mean
  for (std::size_t j = 0; j < kCreepElements; ++j)
    state.psi[j] = target + (state.psi[j] - target) * std::exp(-seconds / d.creep_s[j]);
  state.late = 0.0;
}

}  // namespace tactbench::analysis
