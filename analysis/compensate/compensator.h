// Streaming inverse ELAM for one taxel: voltages in, pressures out, direction detected from the output itself with a
// dead band that follows the taxel's measured noise [A13]; flags where pressure is not observable.
#pragma once

#include <optional>

#include "analysis/models/elam.h"

namespace tactbench::analysis {

struct Compensated {
  double pressure_psi = 0.0;
  bool flat = false;          // slope of the curve too small against the noise: the estimate is weak here
  bool out_of_range = false;  // voltage outside the external loop: clamped
};

struct CompensatorOptions {
  double noise_v = 0.0;               // standard deviation of a sample
  double band_in_noises = 4.0;        // dead band = this x noise_v
  double flat_psi = 2.0;              // flat when band_in_noises x noise / slope exceeds this
};

class TaxelCompensator {
 public:
  // Starts at rest at (x0, y0). Keeps a reference to `model`.
  TaxelCompensator(const ElamModel& model, const CompensatorOptions& options);
  Compensated step(double volts);
  void reset();

 private:
  const ElamModel* model_;
  CompensatorOptions options_;
  std::optional<ElamCurve> curve_;
  double extreme_v_ = 0.0;    // furthest output since the last turn
};

}  // namespace tactbench::analysis
