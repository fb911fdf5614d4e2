#include "analysis/models/gpi.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/models/invert.h"
#include "analysis/models/play_operators.h"

namespace tactbench::analysis {
namespace {

struct Member {
  const char* name;
  double GpiParameters::*value;
  const char* unit;
  bool positive;
  bool fixed = false;  // by convention [A16]: a0 and b0 hold a2 and b2, and the scale is that of alpha and the rest
};
constexpr Member kMembers[] = {
    {"a0", &GpiParameters::a0, "y", true},        {"a1", &GpiParameters::a1, "1/x", true},
    {"a2", &GpiParameters::a2, "1", false, true}, {"a3", &GpiParameters::a3, "y", false},
    {"b0", &GpiParameters::b0, "y", true},        {"b1", &GpiParameters::b1, "1/x", true},
    {"b2", &GpiParameters::b2, "1", false, true}, {"b3", &GpiParameters::b3, "y", false},
    {"alpha", &GpiParameters::alpha, "y", true},  {"rho", &GpiParameters::rho, "1", true, true},
    {"tau", &GpiParameters::tau, "1/y", false}};

class GpiState final : public ModelState {
 public:
  explicit GpiState(const GpiModel& model) : model_(&model) { reset(); }
  void reset() override {
    x_ = model_->x_low();
    operators_ = model_->moved({}, x_);
  }
  [[nodiscard]] double output_at(double x) const override {
    return model_->output(model_->moved(operators_, std::clamp(x, model_->x_low(), model_->x_high())));
  }
  [[nodiscard]] double input_at(double y) const override {
    const double here = model_->output(operators_);
    if (y == here) return x_;
    const double way[] = {x_, y > here ? model_->x_high() : model_->x_low()};
    return first_crossing([&](double x) { return output_at(x); }, way, y);
  }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<GpiState>(*this); }
  void go(double x) override {
    if (!std::isfinite(x)) throw std::invalid_argument("GPI: the input is not a finite number");
    x_ = std::clamp(x, model_->x_low(), model_->x_high());
    operators_ = model_->moved(operators_, x_);
  }

 private:
  const GpiModel* model_;
  double x_ = 0.0;
  GpiModel::Operators operators_{};
};

}  // namespace

GpiModel::GpiModel(const GpiParameters& parameters, double x_low, double x_high, double y_low)
    : p_(parameters),
      x_low_(x_low),
      x_high_(x_high),
      y_low_(y_low),
      a_(p_.a0 * std::exp(p_.a2)),
      b_(p_.b0 * std::exp(p_.b2)) {
  if (!std::isfinite(x_low) || !std::isfinite(x_high) || !(x_low < x_high) || !std::isfinite(y_low))
    throw std::invalid_argument("GPI model: x_low, x_high and y_low must be finite and x_low below x_high");
  for (const Member& m : kMembers)
    if (!std::isfinite(p_.*m.value) || (m.positive && p_.*m.value <= 0.0))
      throw std::invalid_argument(std::string("GPI model: \"") + m.name + "\" is out of range");
  for (int i = 0; i < kGpiOperators; ++i) {
    const auto k = static_cast<std::size_t>(i);
    threshold_[k] = p_.alpha * i;                              // (40)
    density_[k] = p_.rho * std::exp(-p_.tau * threshold_[k]);  // (41)
  }
}

std::vector<ModelParameter> GpiModel::parameters() const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<ModelParameter> list;
  for (const Member& m : kMembers)
    list.push_back({m.name, p_.*m.value, m.unit, m.positive ? 0.0 : -kNone, kNone, m.fixed});
  return list;
}

// Two envelopes (multiply, exponential from a table, multiply, subtract: 4 each), five operators (add, subtract, two
// comparisons), five multiply-adds and the offset.
int GpiModel::operations_per_sample() const { return 2 * 4 + kGpiOperators * (4 + 2) + 1; }

std::unique_ptr<ModelState> GpiModel::state() const { return std::make_unique<GpiState>(*this); }

GpiModel::Operators GpiModel::moved(const Operators& before, double x) const {
  const double left = p_.a3 - a_ * std::exp(-p_.a1 * (x - x_low_));   // (42)
  const double right = p_.b3 - b_ * std::exp(-p_.b1 * (x - x_low_));  // (43)
  Operators now;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] = generalized_play(left, right, threshold_[i], before[i]);
  return now;
}

double GpiModel::output(const Operators& operators) const {
  double y = y_low_;
  for (std::size_t i = 0; i < operators.size(); ++i) y += density_[i] * operators[i];
  return y;
}

ModelMembers GpiModel::members() const { return range_and_parameters(*this, y_low_); }

std::unique_ptr<HysteresisModel> GpiModel::from(const ModelSource& source) {
  const auto p = [&](const char* name) { return source.parameter(name); };
  return std::make_unique<GpiModel>(GpiParameters{p("a0"), p("a1"), p("a2"), p("a3"), p("b0"), p("b1"), p("b2"),
                                                  p("b3"), p("alpha"), p("rho"), p("tau")},
                                    source.number("x_low"), source.number("x_high"), source.number("y_low"));
}

}  // namespace tactbench::analysis
