// Errors of corrected readings: of every frame of a run, pooled by direction and window of pressure, and at each level
// of each full sweep. Input of the uncertainty of a reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr double kHistoryWindowPsi = 4.0;  // to each side of a level

// Every frame of one run, in time order.
struct FrameErrors {
  struct Frame {
    double setpoint_psi = 0.0, reference_psi = 0.0;
    bool full = false, up = true;  // of its branch (step_kinds)
    std::size_t sequence = 0, repeat = 0, step = 0;
    int branch = 0;
  };
  std::int64_t run = 0;
  std::vector<Frame> frames;
  std::vector<double> error_psi;  // frames x taxels: estimate - reference, nothing taken off; NaN where not fitted
};

// Frames of one run that belong together. The run outlives it.
struct FrameHistory {
  const FrameErrors* run = nullptr;
  std::vector<std::size_t> frames;  // places in run->frames
};

// Of the frames within the window of one level that were reached in one direction.
struct WindowErrors {
  double pressure_psi = 0.0;
  bool up = true;
  double frames = 0.0;
  // Separate ways through the window: branches of a sequence (its repeats go the same way), summed over the histories.
  // What one way errs by is nearly one value, so that these and not the frames are the degrees of freedom.
  double branches = 0.0;
  std::vector<double> square_psi;  // taxels: mean square error; NaN where not fitted, or without frames
  double common_square_psi = 0.0;  // mean square of the array's mean error
};

// Errors of a taxel's readings that are taken off: levels up, then down, x taxels, linear in between; empty: none.
using LevelCorrections = std::vector<double>;

// `run`: of the sensor of `fit`, outputs rising (as_modelled). Every frame goes through the compensator in time order.
FrameErrors frame_errors(const Dataset& run, const SensorModel& fit, int threads = 0);

// Levels of the models up, then down, all of them, even without frames. Of all `histories`, or all but one. The error
// of a frame is less the correction at its set-point.
std::vector<WindowErrors> pooled_errors(std::span<const FrameHistory> histories, const SensorModel& fit,
                                        const LevelCorrections& corrections = {},
                                        std::optional<std::size_t> all_but = {});
bool has_any_branch(std::span<const WindowErrors> windows);  // through any of them

// The correction at a pressure, linear between levels and constant beyond them. NaN counts as 0.
double correction_at(const LevelCorrections& corrections, const SensorModel& fit, std::size_t taxel,
                     double pressure_psi, bool up);

// Errors of compensated readings at each level of each full sweep of the external loop; input of the uncertainty of a
// reading.
// All readings at one level on one branch.
struct LevelReadings {
  double pressure_psi = 0.0;  // the level's set-point
  bool up = true;
  std::size_t readings = 0;       // of each taxel: one per full sweep
  std::vector<double> error_psi;  // readings x taxels: estimate - measured reference; NaN where not fitted
  // Of each reading: the group that its sweep belongs to, from 0 (SweepErrors::groups). Sweeps of one group have the
  // same way behind them: same sequence, same place in it.
  std::vector<int> group;
};

struct SweepErrors {
  std::vector<LevelReadings> levels;  // up by rising pressure, then down by rising pressure
  int groups = 0;
  // Taxels: output at the end of a repeat less that at its start, both at the lowest level: mean over the repeats, and
  // their experimental standard deviation (JCGM 100, 4.2.2; 0 of one repeat). NaN where no repeat begins and ends
  // there.
  std::vector<double> zero_return_v, zero_return_s_v;
  std::size_t repeats_with_zero = 0;
};

// Compensates every stored frame in time order, as evaluate() does. A sweep is full when it begins and ends within 1 %
// of the range's ends; levels are the set-points of `fit`'s grid. `fit` must not be falling, and be of this sensor.
SweepErrors sweep_errors(const Dataset& dataset, const SensorModel& fit, int threads = 0);

// Mean error of the readings: levels x taxels; NaN without readings.
std::vector<double> mean_errors(const SweepErrors& errors, std::size_t taxels);

// Compensated pressures of an array at each level of each full loading sweep; used to compare runs of one sensor.
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
  // The place of a level, within 0.05 psi; none: their number.
  [[nodiscard]] std::size_t level(double pressure) const;
};

// Every frame of every repeat in time order through the compensator; sweeps from the lowest to the highest set-point of
// `fit`'s range are kept, of those with the levels of the first. Throws AnalysisError TB-ANALYSIS-OTHER-SENSOR and
// TB-ANALYSIS-ORIGIN as evaluate() does, TB-ANALYSIS-NO-LOOP when there is no full sweep.
SweepEstimates sweep_estimates(const Dataset& dataset, const SensorModel& fit, int threads = 0);

}  // namespace tactbench::analysis
