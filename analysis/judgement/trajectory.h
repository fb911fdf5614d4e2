// Compares the pressure trajectory of a judged run with that of the models' fit: an error is valid only for
// trajectories of the kind on which it was measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/dataset.h"

namespace tactbench::analysis {

enum class Trajectory { kAsFitted, kRandomReversals, kOther };
const char* to_string(Trajectory trajectory);  // "set-points as fitted", "random reversals", "other set-points"

struct JudgedTrajectory {
  std::int64_t run = 0;
  Trajectory trajectory = Trajectory::kAsFitted;
  std::size_t reversals = 0;                   // turning points within the longest sequence
  double inner_share = 0.0;                    // share of the frames on branches that do not span the range
  double dwell_s = 0.0, fitted_dwell_s = 0.0;  // dwell of each run, see below
  bool other_dwell = false;                    // the two dwells differ by more than a fifth
};

// As fitted: each sequence has the same set-points in the same order as a sequence of `fitted`, however often repeated.
// Random reversals: at least eight turning points in a sequence, fewer than a third of them at the ends of the range.
// Dwell: the median time from a set-point's command to its frame, unless set_dwell() sets the requested one.
JudgedTrajectory judged_trajectory(const Dataset& judged, const Dataset& fitted);

// Sets the dwell requested by the recipes, from pressure in band to the frame.
void set_dwell(JudgedTrajectory& judged, double dwell_s, double fitted_dwell_s);

// "random reversals: 32 turning points, 87 % of the frames on inner branches; dwell 2.0 s (fitted: 1.0 s)".
std::string display_text(const JudgedTrajectory& judged);

// trajectory reversals inner_share dwell_s fitted_dwell_s other_dwell; without the run's number.
nlohmann::ordered_json trajectory_json(const JudgedTrajectory& judged);

}  // namespace tactbench::analysis
