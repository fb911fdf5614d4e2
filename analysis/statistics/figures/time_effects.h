// What time does to a reading, for the uncertainty budgets: creep, the output's change from the time under load at
// which the calibration reads its levels to the end of a hold, as a share of the output; and dwell, how corrected
// readings change when the time before a frame is not the calibration's (recipe `rate`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr std::size_t kMinHeldFrames = 20;  // frames of a hold that count
inline constexpr double kHeldAbovePsi = 0.5;       // holds and readings below are not used

// Frames [first, end) of one repeat at one set-point above kHeldAbovePsi, commanded once.
struct HeldFrames {
  std::size_t sequence = 0, repeat = 0, first = 0, end = 0;
  bool rose = true;  // the level was reached from below
  // Since the level was commanded.
  [[nodiscard]] double held_s(const Repeat& at, std::size_t step) const {
    return at.steps[first].held_s + at.steps[step].time_s - at.steps[first].time_s;
  }
};
std::vector<HeldFrames> held_frames_of(const Dataset& dataset, std::size_t fewest_frames = kMinHeldFrames);

// One level that was held. Of several holds of one level on one branch each taxel's largest share counts.
struct HeldLevel {
  std::string sequence;
  double pressure_psi = 0.0;
  bool up = true;
  double from_s = 0.0, to_s = 0.0;  // first and last frame, since the level was commanded
  // Taxels: |V(to_s) - V(read_after_s)| / (V(read_after_s) - V0), what the reference's own movement explains by the
  // model's slope taken off; NaN where not fitted.
  std::vector<double> share;
  double median_share = 0.0;
};

struct CreepEffect {
  std::string not_assessed =
      "one frame is taken a dwell: a run of creep-hold or creep-levels would show it";  // empty: assessed
  double read_after_s = 0.0;  // median time from command to frame in the calibration, at levels above kHeldAbovePsi
  double to_s = 0.0;          // the shortest of the holds: readings up to here are covered
  bool extrapolated_back = false;  // a hold's first frame is later than read_after_s: extended on the logarithm of time
  bool undone = false;             // outputs are those with the model's creep, of the fitted run, undone
  std::vector<HeldLevel> levels;   // by branch, then pressure
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
  // Share of a taxel's output over its zero. Linear between held levels, constant beyond them; a branch without a held
  // level takes the other branch's values.
  [[nodiscard]] double share(std::size_t taxel, double pressure_psi, bool up) const;
  [[nodiscard]] std::string display_text() const;  // data and assumptions in words; empty when not assessed
};

// `runs`: of the same sensor, the calibration itself among them where it holds levels. Of a model with the creep
// of its fitted run, which is of one dwell, the change with that creep undone counts. Not assessed for a model with the
// creep of holds: what that leaves is not seen in holds alike. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
CreepEffect creep_effect_of(const Dataset& calibration, std::span<const Dataset> runs, const SensorModel& fit);

struct DwellEffect {
  std::string not_assessed = "no run of recipe rate was given, the same loop at several dwell times";
  std::int64_t run = 0;
  double low_s = 0.0, high_s = 0.0;  // shortest and longest dwell: times from command to frame, medians of the repeats
  // Levels of the models up, then down, x taxels: the larger over the repeats of the mean square of the change over the
  // window of kHistoryWindowPsi, psi². It contains the noise of two frames. NaN where not fitted.
  std::vector<double> square_psi;
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};

double median_dwell_s(const Dataset& dataset);  // over all frames above kHeldAbovePsi; NaN where none states it

// The first of `runs` with repeats whose dwell times differ by a factor of two tells. Outputs rising (as_modelled).
DwellEffect dwell_effect_of(const Dataset& calibration, std::span<const Dataset* const> runs, const SensorModel& fit,
                            int threads = 0);

}  // namespace tactbench::analysis
