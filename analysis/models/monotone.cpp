#include "analysis/models/monotone.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

class MonotoneState final : public ModelState {
 public:
  explicit MonotoneState(const PatternCurve& curve) : curve_(&curve) {}
  void reset() override {}
  [[nodiscard]] double output_at(double x) const override { return (*curve_)(x); }
  [[nodiscard]] double input_at(double y) const override { return curve_->inverse(y); }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<MonotoneState>(*this); }
  void go(double x) override {
    if (!std::isfinite(x)) throw std::invalid_argument("monotone curve: the input is not a finite number");
  }

 private:
  const PatternCurve* curve_;
};

}  // namespace

MonotoneModel::MonotoneModel(PatternCurve curve) : curve_(std::move(curve)) {
  if (curve_.x().empty()) throw std::invalid_argument("monotone model: the curve has no knots");
}

std::vector<ModelParameter> MonotoneModel::parameters() const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<ModelParameter> list;
  for (std::size_t i = 0; i < curve_.y().size(); ++i)
    list.push_back({std::string("y") + std::to_string(i), curve_.y()[i], "y", -kNone, kNone});
  return list;
}

std::unique_ptr<ModelState> MonotoneModel::state() const { return std::make_unique<MonotoneState>(curve_); }

ModelMembers MonotoneModel::members() const {
  return {{"x", std::vector(curve_.x().begin(), curve_.x().end())},
          {"y", std::vector(curve_.y().begin(), curve_.y().end())}};
}

std::unique_ptr<HysteresisModel> MonotoneModel::from(const ModelSource& source) {
  return std::make_unique<MonotoneModel>(curve_from(source, "y"));
}

}  // namespace tactbench::analysis
