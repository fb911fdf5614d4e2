// Streaming inverse ELAM for one taxel: voltages in, pressures out, direction detected from the output itself with a
// dead band that follows the taxel's measured noise [A13]; flags where pressure is not observable.
#pragma once

#include <optional>

#include "analysis/models/elam.h"

namespace tactbench::analysis {

struct Compensated {
  double pressure_psi = 0.0;
  bool flat = false;          // slope of the curve too small against the noise: the estimate is weak here
  bool out_of_range = false;  // voltage outside the external loop by more than the dead band: clamped
};

struct CompensatorOptions {
  double noise_v = 0.0;         // standard deviation of a sample
  double band_in_noises = 6.0;  // dead band = this x noise_v: a turn is remembered once the output has gone so far back
  double hold_in_noises = 2.0;  // within this x noise_v of the extreme the pressure is taken as held
  double flat_in_noises = 4.0;  // flat when an output this x noise_v off moves the estimate ...
  double flat_psi = 2.0;        // ... by more than this
  double drift_share = 0.01;    // of the output's span: so far below yu a turn's split is that of a turn at xu
};

// Three zones behind the furthest output since the last turn. Within the hold zone the pressure is taken as held: read
// from the current curve, samples averaged into the extreme (the greatest of n noisy samples would be biased). Further
// back the estimate reads the reverse curve from the extreme at once, so that rise and fall are treated alike; but that
// curve is tentative: only beyond the dead band does it become the current one. Wiggles inside leave no memory.
class TaxelCompensator {
 public:
  // Starts at rest at (x0, y0). Keeps a reference to `model`. Throws std::invalid_argument on negative options.
  TaxelCompensator(const ElamModel& model, const CompensatorOptions& options);
  // Throws std::invalid_argument when `volts` is not finite; the state is then as before.
  Compensated step(double volts);
  void reset();
  [[nodiscard]] bool ascending() const { return curve_->ascending(); }

 private:
  void set_extreme(double volts, int samples);
  [[nodiscard]] ElamCurve curve_from_extreme() const;
  [[nodiscard]] bool weak(const ElamCurve& curve, double volts) const;
  const ElamModel* model_;
  CompensatorOptions options_;
  std::optional<ElamCurve> curve_;      // since the last remembered turn
  std::optional<ElamCurve> tentative_;  // the other way from the extreme; made when asked for
  double extreme_v_ = 0.0;              // furthest output since the last turn
  int samples_ = 0;                     // averaged in extreme_v_
};

}  // namespace tactbench::analysis
