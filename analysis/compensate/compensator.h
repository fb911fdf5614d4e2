// Streaming compensators, outputs in, inputs out, sample by sample, for any model: of one taxel and of the whole array.
// The direction of the input is derived from the output, with a dead band that adapts to the noise [A13]. Standard
// library only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "analysis/models/dynamics.h"

namespace tactbench::analysis {

class HysteresisModel;

struct Compensated {
  double pressure_psi = 0.0;  // estimated input, in the model's unit
  double uncertainty_psi =
      0.0;            // standard uncertainty: noise, the unknown part of the history, and the model's residual
  bool flat = false;  // slope of the curve too small relative to the noise: the estimate is uncertain
  bool out_of_range =
      false;  // output beyond the taxel's possible range (possible_share): the reading is the loop's end, or held
  bool unknown = false;  // the history is not known yet: the reading is midway between the extremes
  bool held = false;     // no sample, or an impossible one: the last reading is repeated
};

// kAtRest: at rest at the lowest input. kUnknown: anywhere in the external loop. Of all histories that lead to an
// output, the one that only rose gives the highest input and the one that fell from the top gives the lowest: both are
// tracked, the estimate is midway between them, and the history is unknown until they are close.
enum class Start { kAtRest, kUnknown };

class Compensator {
 public:
  virtual ~Compensator() = default;
  // `seconds` since the previous sample; used only by models with lag and creep. An output that is not a number, or is
  // impossible for the taxel, is held: it makes no turning point and does not change later results. Throws
  // std::invalid_argument if `seconds` is negative or not finite; the state is then unchanged.
  virtual Compensated step(double output, double seconds) = 0;
  // A sample was lost: the next one is accepted without averaging, because the output may have changed arbitrarily
  // meanwhile.
  virtual Compensated lost(double seconds) = 0;
  virtual void start(Start how) = 0;
  // work(): the input cycled over its whole range for `seconds` without being measured, and ended at rest at the lowest
  // input (conditioning). rest(): the load was removed and the film rested for `seconds`. Both advance lag and creep;
  // rest() then starts at rest.
  virtual void work(double seconds) = 0;
  virtual void rest(double seconds) = 0;
  // `output` of the unloaded taxel becomes its zero, and the taxel is at rest. False: the zero would move by more than
  // tare_share of the span; it is kept, and the history is unknown.
  virtual bool tare(double output) = 0;
  // Whether `output` is the unloaded output, within the dead band and 1 % of the span.
  [[nodiscard]] virtual bool at_rest(double output) const = 0;
  [[nodiscard]] virtual bool ascending() const = 0;
};

// The defaults of noise and turns were found by a random search over random reversals of 8 synthetic taxels, with 1.5
// to 32 mV of noise and 0.004 to 2 psi per sample; they are a compromise. Not verified on hardware.
struct CompensatorOptions {
  double moving = 2.4;  // mean square of the steps, in units of the noise variance, above which nothing is averaged
  double jump_in_noises = 5.0;   // a sample further from the mean than this x the noise starts a new mean
  int longest_mean = 8;          // a constant output is averaged over up to this many samples
  double lead_in_noises = 1.75;  // the highest of many means exceeds the true extreme by this x the noise of a mean
  double band_in_noises = 5.5;   // dead band: a turn is stored once the mean has gone back by this x its noise
  double rest_in_noises = 3.0;   // an extreme within this x the noise of the output's resting value was noise
  double hold_in_noises = 1.6;   // within this x the mean's noise of the extreme, the output has not turned
  double flat_in_noises = 4.0;   // flat when an output this x the mean's noise off moves the estimate ...
  double flat_share = 1.0 / 30;  // ... by more than this share of the range of inputs
  double known_share =
      1.0 / 120;  // an unknown start ends when the two histories differ by less than this share of the range of inputs
  double tare_share = 0.2;  // of the output's span, by which a tare may move the zero
  // A taxel can give outputs of its external loop and, by drift, outputs beyond it by this share of the span (at least
  // the dead band): they read as the loop's end, and u includes the input change that an equal change of output means
  // inside the loop. Outputs further out are held, unless more than longest_spike of them come in a row, or they come
  // from nearby.
  double possible_share = 0.05;
  int longest_spike = 3;
  // A turn from rising to falling within `top_share` of the full output, or above it, counts as a turn at full input if
  // it is the highest for a long time; outputs are then scaled accordingly. `top_forget`: how far the stored highest
  // moves toward each lower turn within that share. A changed gain indicates a new mount or drift: u includes top_doubt
  // x |1 - gain| x the input above the lowest. 0: off.
  double top_share = 0.0, top_forget = 0.02, top_doubt = 3.0;
  // Creep is known only approximately: u includes, through the slope, the share creep_doubt of each creep element that
  // has not settled, and for the fastest element at least the share swift_doubt of the output, which covers lag.
  double creep_doubt = 0.08, swift_doubt = 0.02;
};

// The target of the creep is extrapolated along the slope of the last reading. If the curve is flat there, the slope
// holds only for a small piece, so it is limited to this x the mean slope.
inline constexpr double kSteepestGuess = 4.0;

// CompensatorOptions::top_share for models with lag and creep.
inline constexpr double kTopShare = 0.005;

// Remaining shares of lag and creep after the time between two samples; shared by the taxels of an array.
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
  double noise = 0.0;             // standard deviation of a sample of the output
  double highest = 0.0;           // highest output of the measured external loop; 0: use the model's
  // The model's residual, root mean square, in equal intervals of the inputs: rising, then falling. Empty: not known.
  std::vector<double> residual;
  std::shared_ptr<PassedTime> time;  // null: no lag, no creep
  double creep_scale = 1.0, lag_share = 0.0;
  double worked_s = 0.0;  // before a start: how long the input cycled over its range; 0: it had rested for long
  CompensatorOptions options;
};

// Makes a compensator at rest. Keeps a pointer to `model`. Throws std::invalid_argument that names a value out of
// bounds.
std::unique_ptr<Compensator> make_compensator(const HysteresisModel& model, const CompensatorSetup& setup);

// Compensates frames of the array: outputs in, pressures out; one streaming compensator per taxel, without allocation
// after construction.
// Status of a taxel in a frame. The bits are fixed: new ones may be added, none is moved.
enum TaxelBits : std::uint16_t {
  kTaxelValid = 1,       // computed from this frame's sample, within the model's range and validity
  kTaxelFlat = 2,        // small slope: the noise corresponds to much pressure, see the uncertainty
  kTaxelOutOfRange = 4,  // output outside the external loop by more than drift explains: pressure clamped or repeated;
                         // uncertainty meaningless, not valid
  kTaxelDead = 8,        // not usable by its model: lowest pressure, uncertainty the whole span
  kTaxelOutside = 16,    // conditions outside the model's validity, as set by the caller: not valid
  kTaxelUnknown = 32,    // history not known yet: pressure midway between the extremes, see the uncertainty
  kTaxelLost = 64,       // no sample (frame lost, or not a finite number): the last pressure is repeated, not valid
};

class FrameCompensator {
 public:
  // One entry per taxel; each span has taxels() entries.
  struct Output {
    std::span<float> pressure_psi;
    std::span<float> uncertainty_psi;  // standard uncertainty
    std::span<std::uint16_t> status;   // TaxelBits
  };
  struct Setup {
    std::vector<std::unique_ptr<Compensator>> taxels;  // null: dead
    double x_low = 0.0, x_high = 1.0;
    bool in_time = false;  // the compensators remove lag or creep, and need the time
    int max_gap = 10;      // number of consecutive lost frames after which all histories are unknown
  };
  explicit FrameCompensator(Setup setup) : setup_(std::move(setup)) {}

  [[nodiscard]] std::size_t taxels() const { return setup_.taxels.size(); }
  // Whether the next frame needs the time since the previous one.
  [[nodiscard]] bool needs_time() const { return setup_.in_time && begun_; }
  // One measured frame, `seconds` after the previous one (NaN: not known). Throws std::invalid_argument when a span's
  // length is not taxels(), seconds are negative or infinite, or not known to a model that needs them; the state is
  // then unchanged. The seconds of the first frame are not used.
  void frame(std::span<const float> outputs, double seconds, const Output& output);
  void lost_frame(double seconds, const Output& output);
  void start(Start how);
  void work(double seconds);  // as Compensator::work()
  // `outputs` are those of the unloaded sensor. Returns the number of taxels that were refused (Compensator::tare).
  std::size_t tare(std::span<const float> outputs);
  // Set by the caller after comparing temperature, rate, mount and other conditions with the model's validity.
  void set_outside_validity(bool outside) { outside_ = outside; }

 private:
  double checked(std::size_t outputs, double seconds, const Output& output);
  void put(std::size_t taxel, const Compensated& now, int bits, const Output& output) const;

  Setup setup_;
  bool outside_ = false, begun_ = false;
  int gap_ = 0;
};

}  // namespace tactbench::analysis
