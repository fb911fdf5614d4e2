// The readout of a resistive taxel as a divider, and the way back: u = v / (1 - c v), v counted from the unloaded
// output (bench/simulation/README.md, 4). u is what the contact's conductance would give
// without the divider, in the output's unit where v is small.
#pragma once

#include <algorithm>

namespace tactbench::analysis {

struct Divider {
  double zero = 0.0;                      // output without load
  double per_amplitude = 0.0;             // c = 1 / A, A the highest output that the divider can give; 0: none, u = v
  static constexpr double kMost = 0.995;  // of A: outputs above are taken as this

  [[nodiscard]] double linear(double output) const {
    const double v = output - zero, share = v * per_amplitude;
    return share <= kMost ? v / (1.0 - share) : linear_end() + (v - kMost / per_amplitude);
  }
  [[nodiscard]] double output(double u) const {
    if (per_amplitude > 0.0 && u > linear_end()) return zero + kMost / per_amplitude + (u - linear_end());
    return zero + u / (1.0 + u * per_amplitude);
  }
  [[nodiscard]] double linear_end() const { return kMost / per_amplitude / (1.0 - kMost); }
};

}  // namespace tactbench::analysis
