// Errors of corrected readings along pressure histories: of every frame of a run, and pooled by direction and by a
// window of pressure. They give the error of a reading at any point of a kind of history.
#pragma once

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

}  // namespace tactbench::analysis
