// What a dynamic compensator is made of: an array's lag and creep, and each taxel's Preisach model on its linearised
// output.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/compensate/options.h"
#include "analysis/models/divider.h"
#include "analysis/models/dynamics.h"

namespace tactbench::analysis {

struct DynamicTaxel {
  bool usable = false;          // false (dead, stuck, saturated, unfit): the other members are not read
  Divider divider;              // of the output as modelled: negated where the sensor falls
  std::vector<double> everett;  // in u: everett.h's table, of n intervals
  double creep_scale = 1.0, lag_share = 0.0;
  double noise_v = 0.0;  // standard deviation of a sample
  double residual_scale = 1.0;
  bool falling = false;  // samples are negated [A20]
};

// The gain at the top: a turn from rising to falling within `share` of the full output below the top, or any beyond, is
// taken for one at full pressure when it is the highest that was seen for long: outputs are scaled so that it is.
struct GainObserver {
  double share = 0.02;
  double forget = 0.02;  // how far the highest goes toward each lower turn within the share
  // A gain that changed tells of a new mount or of drift, and near the top, where the output is flat, of pressures that
  // changed by a larger share. The uncertainty has a part of this times |1 - gain| times the pressure above the lowest.
  double doubt = 5.0;
};

struct DynamicSetup {
  double x_low = 0.0, x_high = 1.0;  // psi
  std::size_t intervals = 0;         // n of all tables
  Dynamics dynamics;
  std::vector<DynamicTaxel> taxels;
  // Root mean square of what the model leaves, psi, by interval: rising, then falling; times residual_scale a taxel's.
  // Empty: not known, the uncertainty is noise alone.
  std::vector<double> residual_psi;
  double volts_per_count = 0.0;
  CompensatorOptions options;  // its noise_v and drift_share are not used
  GainObserver observer;
  bool start_unknown = true;
  double worked_s = 0.0;    // before a start: how long the pressure went over its range; 0: it rested for long
  int longest_gap = 10;     // frames lost in a row after which the history is unknown
  double tare_share = 0.2;  // as FrameSetup's
};

// All but the taxels and what only frames need. Throws std::invalid_argument.
void check_setup(const DynamicSetup& setup);
// One that is usable, within a setup that was checked. Throws std::invalid_argument.
void check_taxel(const DynamicSetup& setup, const DynamicTaxel& taxel);
// The most that creep may take of an output: what is left is divided by.
inline constexpr double kMostCreep = 0.9, kMostCreepScale = 10.0;
// The creep's target is guessed along the slope of the last reading. Where the film is flat that slope says nothing
// beyond a small piece: it is at most this x the mean one, full pressure over full output. Chosen on sensor seeds 1
// and 2 of both specimens; 2 to 8 do nearly the same.
inline constexpr double kSteepestGuess = 4.0;

}  // namespace tactbench::analysis
