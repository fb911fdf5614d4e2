// Streaming compensator of one taxel: outputs in, inputs out, sample by sample, for any model. The direction comes from
// the output itself, with a dead band that follows its noise [A13]. Standard library only.
#pragma once

#include <memory>
#include <vector>

#include "analysis/models/dynamics.h"

namespace tactbench::analysis {

class HysteresisModel;

struct Compensated {
  double pressure_psi = 0.0;     // the input, in the unit of the model's
  double uncertainty_psi = 0.0;  // standard: noise, the unknown part of the history, and what the model leaves
  bool flat = false;             // slope of the curve too small against the noise: the estimate is weak here
  bool out_of_range = false;     // output beyond what the taxel can give (possible_share): the loop's end, or held
  bool unknown = false;          // the history is not known yet: midway between its extremes
  bool held = false;             // no sample, or one that the taxel cannot give: the last reading again
};

// At rest at the lowest input, or anywhere in the external loop. Of all histories that end in an output, one that only
// rose ends highest in input and one that fell from the top ends lowest: both are followed, the estimate lies midway,
// and the state is unknown until they are close.
enum class Start { kAtRest, kUnknown };

class Compensator {
 public:
  virtual ~Compensator() = default;
  // `seconds` since the sample before; only models with lag and creep look at it. An output that is no number, or that
  // the taxel cannot give, is held: no turning point, and what follows is as without it. Throws std::invalid_argument
  // when `seconds` is negative or not finite; the state is then as before.
  virtual Compensated step(double output, double seconds) = 0;
  // A sample was lost: the next one is taken as it comes, since the output may have gone anywhere meanwhile.
  virtual Compensated lost(double seconds) = 0;
  virtual void start(Start how) = 0;
  // work(): for so long the input cycled over its whole range without being measured, and came to rest at the lowest:
  // conditioning. rest(): the load was removed and the film rested for so long. Both advance lag and creep; rest()
  // starts at rest.
  virtual void work(double seconds) = 0;
  virtual void rest(double seconds) = 0;
  // `output` is that of the unloaded taxel: it becomes its zero, and the taxel is at rest. False: it would move by more
  // than tare_share of the span; the zero stays, and the history is unknown.
  virtual bool tare(double output) = 0;
  // Whether `output` is the unloaded one, within the dead band and 1 % of the span.
  [[nodiscard]] virtual bool at_rest(double output) const = 0;
  [[nodiscard]] virtual bool ascending() const = 0;
};

// The defaults of noise and turns were found by a random search over random reversals of 8 synthetic taxels, 1.5 to 32
// mV of noise and 0.004 to 2 psi a sample; a compromise. Not verified on hardware.
struct CompensatorOptions {
  double moving = 2.4;             // mean square of a sample's step, in noises squared, above which nothing is averaged
  double jump_in_noises = 5.0;     // a sample this x the noise from the mean before it starts a new mean
  int longest_mean = 8;            // samples: an output that does not move is averaged over up to this many
  double lead_in_noises = 1.75;    // the highest of many means lies above the true extreme by this x a mean's noise
  double band_in_noises = 5.5;     // dead band: a turn is remembered once the mean is this x its noise back
  double rest_in_noises = 3.0;     // an extreme within this x the noise of where the output came to rest was noise
  double hold_in_noises = 1.6;     // within this x the mean's noise of the extreme the output has not turned
  double flat_in_noises = 4.0;     // flat when an output this x the mean's noise off moves the estimate ...
  double flat_share = 1.0 / 30;    // ... by more than this share of the range of inputs
  double known_share = 1.0 / 120;  // an unknown start is over when the two histories are within this share of it
  double tare_share = 0.2;         // of the output's span
  // A taxel can give outputs of its external loop, and beyond it by drift, this share of the span (at least the dead
  // band): they read the loop's end, and u has what as much output is worth inside it. What lies beyond is held, unless
  // it came so often in a row, and one more time, or from nearby.
  double possible_share = 0.05;
  int longest_spike = 3;
  // A turn from rising to falling within `top_share` of the full output, or any beyond, is taken for one at full input
  // when it is the highest that was seen for long: outputs are scaled so that it is. `top_forget`: how far the highest
  // goes toward each lower turn within that share. A gain that changed tells of a new mount or of drift: u has
  // top_doubt x |1 - gain| x the input above the lowest. 0: off.
  double top_share = 0.0, top_forget = 0.02, top_doubt = 3.0;
  // What a film does in time is known in part: u has this share of each creep that is not settled, of the fastest at
  // least so much of the output (lag is no slower), through the slope.
  double creep_doubt = 0.08, swift_doubt = 0.02;
};

// The creep's target is guessed along the slope of the last reading. Where the film is flat that slope says nothing
// beyond a small piece: it is at most this x the mean one.
inline constexpr double kSteepestGuess = 4.0;

// CompensatorOptions::top_share where lag and creep are removed.
inline constexpr double kTopShare = 0.005;

// What remains of lag and creep after the time between two samples; shared by the taxels of an array.
struct PassedTime {
  Dynamics dynamics;
  double seconds = -1.0;
  DynamicsStep step;
  const DynamicsStep& after(double passed) {
    if (passed != seconds) step = DynamicsStep(dynamics, seconds = passed);
    return step;
  }
};

struct CompensatorSetup {
  double zero = 0.0, gain = 1.0;  // output = zero + gain x the model's
  double noise = 0.0;             // standard deviation of a sample, of the output
  double highest = 0.0;           // of the external loop as measured, an output of the model; 0: as the model has it
  // What the model leaves, root mean square, by equal intervals of the inputs: rising, then falling. Empty: not known.
  std::vector<double> residual;
  std::shared_ptr<PassedTime> time;  // null: no lag, no creep
  double creep_scale = 1.0, lag_share = 0.0;
  double worked_s = 0.0;  // before a start: how long the input went over its range; 0: it rested for long
  CompensatorOptions options;
};

// At rest. Keeps a pointer to `model`. Throws std::invalid_argument that says what is not within its bounds.
std::unique_ptr<Compensator> make_compensator(const HysteresisModel& model, const CompensatorSetup& setup);

}  // namespace tactbench::analysis
