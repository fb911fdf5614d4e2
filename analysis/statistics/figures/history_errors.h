// Errors of corrected readings over histories: of every frame of some runs, by direction and by a window of pressure,
// beside what full sweeps show of the same windows. From them comes what a reading errs by at any point of any history.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr double kHistoryWindowPsi = 4.0;  // to each side of a level

// Of the frames within the window of one level that were reached in one direction.
struct WindowErrors {
  double pressure_psi = 0.0;
  bool up = true;
  double frames = 0.0;
  // Separate ways through the window: branches of a sequence (its repeats go the same way), summed over the runs. What
  // one way errs by is nearly one value, so that these and not the frames are the degrees of freedom.
  double branches = 0.0;
  std::vector<double> mean_psi, square_psi;  // taxels: mean error and mean square of it; NaN where not fitted
  double common_square_psi = 0.0;            // mean square of the array's mean error
};

enum class BranchesOf { kFullSweeps, kInnerBranches, kAll };

// The frames of one run that count, in time order.
struct FrameErrors {
  struct Frame {
    double setpoint_psi = 0.0, reference_psi = 0.0;
    bool up = true;
    std::size_t sequence = 0;
    int branch = 0;
  };
  std::int64_t run = 0;
  std::vector<Frame> frames;
  std::vector<double> error_psi;  // frames x taxels: estimate - reference, nothing taken off; NaN where not fitted
  std::vector<double> held_s;     // of all frames of the run: time from command to frame
};

struct HistoryErrors {
  std::vector<std::int64_t> runs;                // empty: no run, no windows
  double dwell_low_s = 0.0, dwell_high_s = 0.0;  // 5 and 95 % quantile of the time from command to frame
  std::vector<WindowErrors> windows;             // levels of the models up, then down; all with their frames, even none
  [[nodiscard]] bool known() const { return !runs.empty(); }
  [[nodiscard]] bool any_way() const;  // through any window
};

// Errors of a taxel's readings that are taken off: levels up, then down, x taxels, linear in between; empty: none.
using LevelCorrections = std::vector<double>;

// `run`: of the sensor of `fit`, outputs rising (as_modelled). Every frame goes through the compensator in time order;
// those of sequences named in `left_out` do not count.
FrameErrors frame_errors(const Dataset& run, const SensorModel& fit, BranchesOf which, int threads = 0,
                         std::span<const std::string> left_out = {});
// Of all `runs`, or all but one. The error of a frame is less the correction at its set-point.
HistoryErrors pooled_errors(std::span<const FrameErrors> runs, const SensorModel& fit,
                            const LevelCorrections& corrections = {}, std::optional<std::size_t> all_but = {});

// The correction at a pressure, linear between levels and constant beyond them. NaN counts as 0.
double correction_at(const LevelCorrections& corrections, const SensorModel& fit, std::size_t taxel,
                     double pressure_psi, bool up);

}  // namespace tactbench::analysis
