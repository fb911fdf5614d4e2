// Any hysteresis model on the linearised output: what it models is u = v / (1 - c v) of the measured output
// (divider.h), one number a taxel more.
#pragma once

#include "analysis/models/divider.h"
#include "analysis/models/model.h"

namespace tactbench::analysis {

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
