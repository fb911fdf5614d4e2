// Errors of corrected readings over histories: of every frame of some runs, by direction and by a window of pressure,
// beside what full sweeps show of the same windows. From them comes what a reading errs by at any point of any history.
#pragma once

#include <cstdint>
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

struct HistoryErrors {
  std::vector<std::int64_t> runs;                // empty: no run, no windows
  double dwell_low_s = 0.0, dwell_high_s = 0.0;  // 5 and 95 % quantile of the time from command to frame
  std::vector<WindowErrors> windows;             // levels of the models up, then down; all with their frames, even none
  [[nodiscard]] bool known() const { return !runs.empty(); }
};

enum class BranchesOf { kFullSweeps, kInnerBranches, kAll };

// Errors of a taxel's readings that are taken off: levels up, then down, x taxels, linear in between; empty: none.
using LevelCorrections = std::vector<double>;

// `runs`: of the sensor of `fit`, outputs rising (as_modelled). The error of a frame is estimate - reference -
// correction at its set-point. Every frame goes through the compensator in time order.
HistoryErrors history_errors(std::span<const Dataset* const> runs, const SensorModel& fit, BranchesOf which,
                             const LevelCorrections& corrections = {}, int threads = 0);

// The correction at a pressure, linear between levels and constant beyond them. NaN counts as 0.
double correction_at(const LevelCorrections& corrections, const SensorModel& fit, std::size_t taxel,
                     double pressure_psi, bool up);

}  // namespace tactbench::analysis
