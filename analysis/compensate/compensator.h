// Streaming inverse ELAM for one taxel: voltages in, pressures out, direction detected from the output itself with a
// dead band that follows the taxel's measured noise [A13]; flags where pressure is not observable. This is the plain
// form: FrameCompensator computes the same for whole frames, and is tested against it.
#pragma once

#include <optional>

#include "analysis/compensate/options.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis {

struct Compensated {
  double pressure_psi = 0.0;
  double uncertainty_psi = 0.0;  // standard uncertainty: from noise, and from the unknown part of the history
  bool flat = false;             // slope of the curve too small against the noise: the estimate is weak here
  bool out_of_range = false;     // voltage outside the external loop by more than the dead band: clamped
  bool unknown = false;          // the history is not known yet: midway between its extremes
};

// An output that moves by more than its noise from sample to sample is taken as it comes; one that does not is averaged
// over up to 8 samples. Behind the furthest mean since the last turn lie three zones, as wide as that mean's noise:
// "held" reads the current curve; further back the estimate reads the reverse curve from the extreme at once, so that
// rise and fall are treated in the same way, but that curve is tentative; only beyond the dead band does it become the
// current one. Wiggles inside leave no memory, and a slow fall is not averaged away, since the extreme never comes
// back.
class TaxelCompensator {
 public:
  // Starts at rest at (x0, y0). Keeps a reference to `model`. Throws std::invalid_argument on negative options.
  TaxelCompensator(const ElamModel& model, const CompensatorOptions& options);
  // Throws std::invalid_argument when `volts` is not finite; the state is then as before.
  Compensated step(double volts);
  void reset();
  // Starts from anywhere in the external loop. Of all histories that end in an output, one that only rose ends highest
  // in pressure and one that fell from the top ends lowest: both are followed, the estimate lies midway, and the state
  // is unknown until they are within known_psi of each other.
  void reset_unknown();
  [[nodiscard]] bool ascending() const { return ascending_; }

 private:
  void follow(double volts);
  void take_extreme();
  void decide_when_beyond();
  void turn_when_beyond();
  void settle_history(Compensated& result);
  [[nodiscard]] double extreme() const;
  [[nodiscard]] double behind_extreme() const;
  [[nodiscard]] double squared_noise(double noises) const;  // of the noisier of mean and extreme
  [[nodiscard]] ElamCurve reversed(const ElamCurve& curve) const;
  [[nodiscard]] double sensitivity(const ElamCurve& curve) const;  // psi/V over the flat criterion's step
  [[nodiscard]] Compensated read(const ElamCurve& curve) const;

  const ElamModel* model_;
  CompensatorOptions options_;
  ElamCurve curve_;                 // since the last remembered turn
  std::optional<ElamCurve> other_;  // unknown history: the same of the one that fell from the top
  bool started_ = true;             // false: no sample yet
  bool decided_ = true;             // false: rises or falls, not known yet
  bool ascending_ = true;
  bool held_ = true;                             // the last sample advanced by no more than noise
  double steps_ = kStepCeiling;                  // running mean square of the steps, in noises squared
  double mean_v_ = 0.0, gain_ = 1.0;             // and the last sample's weight in it: 1 over their number
  double extreme_v_ = 0.0, extreme_gain_ = 1.0;  // furthest mean since the last turn, and its gain then
};

}  // namespace tactbench::analysis
