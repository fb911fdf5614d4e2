#include "analysis/models/linearised.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

class LinearisedState final : public ModelState {
 public:
  LinearisedState(const Divider& divider, std::unique_ptr<ModelState> inner)
      : divider_(divider), inner_(std::move(inner)) {}
  void reset() override { inner_->reset(); }
  [[nodiscard]] double output_at(double x) const override { return divider_.output(inner_->output_at(x)); }
  [[nodiscard]] double input_at(double y) const override { return inner_->input_at(divider_.linear(y)); }
  void go(double x) override { inner_->go(x); }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override {
    return std::make_unique<LinearisedState>(divider_, inner_->clone());
  }
  void measured(double y) override { inner_->measured(divider_.linear(y)); }

 private:
  Divider divider_;
  std::unique_ptr<ModelState> inner_;
};

}  // namespace

LinearisedModel::LinearisedModel(Divider divider, std::shared_ptr<const HysteresisModel> inner)
    : divider_(divider), inner_(std::move(inner)) {
  if (inner_ == nullptr) throw std::invalid_argument("linearised model: it holds no model");
  if (!std::isfinite(divider.zero) || !std::isfinite(divider.per_amplitude) || divider.per_amplitude < 0.0)
    throw std::invalid_argument("linearised model: \"zero\" or \"per_amplitude\" is not finite or below 0");
}

std::vector<ModelParameter> LinearisedModel::parameters() const {
  // Where it is off, c = 0 is no bound that was met.
  const double c = divider_.per_amplitude;
  std::vector<ModelParameter> list = {{"c", c, "1/y", c > 0.0 ? 0.0 : -HUGE_VAL, HUGE_VAL}};
  for (ModelParameter& own : inner_->parameters()) list.push_back(std::move(own));
  return list;
}

std::unique_ptr<ModelState> LinearisedModel::state() const {
  return std::make_unique<LinearisedState>(divider_, inner_->state());
}

}  // namespace tactbench::analysis
