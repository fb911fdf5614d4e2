#include "analysis/models/monotone.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/json_members.h"

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

std::unique_ptr<MonotoneModel> MonotoneModel::from_json(const nlohmann::ordered_json& json) {
  const std::vector<double> x = json_numbers(json, "x"), y = json_numbers(json, "y");
  if (y.empty()) throw std::invalid_argument("\"y\" is an empty list");
  return std::make_unique<MonotoneModel>(PatternCurve(x, y, y.front(), y.back()));
}

std::vector<ModelParameter> MonotoneModel::parameters() const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<ModelParameter> list;
  for (std::size_t i = 0; i < curve_.y().size(); ++i)
    list.push_back({fmt::format("y{}", i), curve_.y()[i], "y", -kNone, kNone});
  return list;
}

std::unique_ptr<ModelState> MonotoneModel::state() const { return std::make_unique<MonotoneState>(curve_); }

nlohmann::ordered_json MonotoneModel::to_json() const {
  const auto list = [](std::span<const double> values) { return std::vector<double>(values.begin(), values.end()); };
  return {{"model", name()}, {"x", list(curve_.x())}, {"y", list(curve_.y())}};
}

}  // namespace tactbench::analysis
