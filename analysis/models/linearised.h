// Any hysteresis model on the linearised output: what it models is u = v / (1 - c v) of the measured output, one number
// a taxel more.
#pragma once

#include <algorithm>

#include "analysis/models/model.h"

namespace tactbench::analysis {

// The readout of a resistive taxel as a divider, and the way back: u = v / (1 - c v), v counted from the unloaded
// output (bench/simulation/README.md, 4). u is what the contact's conductance would give
// without the divider, in the output's unit where v is small.
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

class LinearisedModel final : public HysteresisModel {
 public:
  // `inner` maps inputs to u. Throws std::invalid_argument when it is null, the zero is not finite, or c is negative or
  // not finite.
  LinearisedModel(Divider divider, std::shared_ptr<const HysteresisModel> inner);

  [[nodiscard]] std::string name() const override { return inner_->name(); }
  [[nodiscard]] ModelMembers members() const override {  // without the inner model
    return {{"zero", divider_.zero}, {"per_amplitude", divider_.per_amplitude}};
  }
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;  // "c" and the inner model's
  [[nodiscard]] double x_low() const override { return inner_->x_low(); }
  [[nodiscard]] double x_high() const override { return inner_->x_high(); }
  [[nodiscard]] int operations_per_sample() const override { return inner_->operations_per_sample() + 2; }
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  [[nodiscard]] const Divider& divider() const { return divider_; }
  [[nodiscard]] const HysteresisModel& inner() const { return *inner_; }

 private:
  Divider divider_;
  std::shared_ptr<const HysteresisModel> inner_;
};

}  // namespace tactbench::analysis
