#include "analysis/models/poly.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/models/invert.h"

namespace tactbench::analysis {
namespace {

double horner(std::span<const double> c, double t) {  // c[k] t^k
  double sum = 0.0;
  for (std::size_t k = c.size(); k-- > 0;) sum = sum * t + c[k];
  return sum;
}

// Places in 0..1 where the polynomial changes its sign: at most one between two neighbouring extremes.
std::vector<double> sign_changes(const std::vector<double>& c) {
  if (c.size() < 2) return {};
  std::vector<double> derivative;
  for (std::size_t k = 1; k < c.size(); ++k) derivative.push_back(static_cast<double>(k) * c[k]);
  std::vector<double> places = sign_changes(derivative), changes;
  places.insert(places.begin(), 0.0);
  places.push_back(1.0);
  const auto output = [&](double t) { return horner(c, t); };
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double way[] = {places[i - 1], places[i]};
    if ((output(way[0]) < 0.0) != (output(way[1]) < 0.0)) changes.push_back(first_crossing(output, way, 0.0));
  }
  return changes;
}

class PolyState final : public ModelState {
 public:
  explicit PolyState(const PolyModel& model) : model_(&model), up_(model.extremes(true)), down_(model.extremes(false)) {
    reset();
  }
  void reset() override { set_external_branch(true, model_->x_low()); }
  [[nodiscard]] double output_at(double x) const override {
    x = std::clamp(x, model_->x_low(), model_->x_high());
    return x == x_ ? y_ : model_->output(branch(x > x_), x);
  }
  [[nodiscard]] double input_at(double y) const override {
    if (y == y_) return x_;
    const PolyModel::Turn turn = branch(y > y_);
    return first_crossing([&](double x) { return model_->output(turn, x); }, pieces(turn), y);
  }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<PolyState>(*this); }
  void go(double x) override {
    if (!std::isfinite(x)) throw std::invalid_argument("POLY: the input is not a finite number");
    x = std::clamp(x, model_->x_low(), model_->x_high());
    if (x == x_) return;  // [A8]
    turn_ = branch(x > x_);
    x_ = x;
    y_ = model_->output(turn_, x);
    anchored_ = false;
  }
  void measured(double y) override {
    if (!std::isfinite(y)) throw std::invalid_argument("POLY: the measured output is not a finite number");
    const double near = kPolyOuterShare * (model_->x_high() - model_->x_low());
    if (x_ - model_->x_low() <= near || model_->x_high() - x_ <= near) {
      set_external_branch(x_ - model_->x_low() <= near, x_);
      return;
    }
    y_ = y;
    anchored_ = true;
  }

 private:
  void set_external_branch(bool ascending, double x) {  // an external branch
    turn_ = model_->external(ascending);
    x_ = x;
    y_ = model_->output(turn_, x);
    anchored_ = false;
  }
  [[nodiscard]] PolyModel::Turn branch(bool up) const {
    if (up == turn_.ascending && !anchored_) return turn_;
    return {up, x_, y_};
  }
  // Places where the output may change direction on the way from here to the branch's end, both included.
  [[nodiscard]] std::vector<double> pieces(const PolyModel::Turn& turn) const {
    std::vector<double> way{x_};
    if (turn.ascending) {
      for (const double t : up_)
        if (const double x = turn.x + t * (model_->x_high() - turn.x); x > x_) way.push_back(x);
    } else {
      for (auto t = down_.rbegin(); t != down_.rend(); ++t)
        if (const double x = model_->x_low() + *t * (turn.x - model_->x_low()); x < x_) way.push_back(x);
    }
    way.push_back(turn.ascending ? model_->x_high() : model_->x_low());
    return way;
  }
  const PolyModel* model_;
  std::vector<double> up_, down_;  // extremes
  PolyModel::Turn turn_;
  double x_ = 0.0, y_ = 0.0;
  bool anchored_ = false;  // measured here: any way on is a new branch
};

}  // namespace

PolyModel::PolyModel(const PolyParameters& parameters, double x_low, double x_high, double y_low, double y_high)
    : p_(parameters), x_low_(x_low), x_high_(x_high), y_low_(y_low), y_high_(y_high) {
  if (!std::isfinite(x_low) || !std::isfinite(x_high) || !std::isfinite(y_low) || !std::isfinite(y_high) ||
      !(x_low < x_high) || !(y_low < y_high))
    throw std::invalid_argument("POLY model: the ends must be finite, low below high");
  const auto shape_of = [&](const std::array<double, kPolyOrder + 1>& f, const char* member) {
    Shape shape;
    double power = 1.0, rise = 0.0;
    for (std::size_t k = 0; k < kPolyOrder; ++k) {
      power *= x_high - x_low;
      shape[k] = f[kPolyOrder - 1 - k] * power;
      rise += shape[k];
    }
    for (double& c : shape) c /= rise;
    const auto finite = [](double c) { return std::isfinite(c); };
    if (!std::ranges::all_of(shape, finite) || !std::ranges::all_of(f, finite))
      throw std::invalid_argument(std::string("POLY model: \"") + member +
                                  "\" is not a polynomial that differs at the two ends");
    return shape;
  };
  up_ = shape_of(p_.a, "a");
  down_ = shape_of(p_.b, "b");
}

std::vector<ModelParameter> PolyModel::parameters() const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<ModelParameter> list;
  for (const auto& [letter, f] : {std::pair{"a", &p_.a}, std::pair{"b", &p_.b}})
    for (std::size_t i = 0; i <= kPolyOrder; ++i) {
      const std::size_t power = kPolyOrder - i;
      const std::string unit = power == 0 ? "y" : power == 1 ? "y/x" : std::string("y/x^") + std::to_string(power);
      list.push_back({std::string(letter) + std::to_string(i), (*f)[i], unit, -kNone, kNone});
    }
  return list;
}

// Direction and two clamps (3), the input's share of the branch (2), the polynomial (11), its stretch (2). The
// reciprocal of the branch's length is taken once a turn.
int PolyModel::operations_per_sample() const { return 18; }

std::unique_ptr<ModelState> PolyModel::state() const { return std::make_unique<PolyState>(*this); }

double PolyModel::value(const Shape& shape, double t) { return t * horner(shape, t); }

double PolyModel::output(const Turn& turn, double x) const {
  if (turn.ascending) {
    if (x <= turn.x || turn.x >= x_high_) return turn.y;
    return turn.y + (y_high_ - turn.y) * value(up_, (x - turn.x) / (x_high_ - turn.x));  // (6)
  }
  if (x >= turn.x || turn.x <= x_low_) return turn.y;
  return y_low_ + (turn.y - y_low_) * value(down_, (x - x_low_) / (turn.x - x_low_));  // (7)
}

std::vector<double> PolyModel::extremes(bool ascending) const {
  std::vector<double> slope;
  for (const double c : ascending ? up_ : down_) slope.push_back(static_cast<double>(slope.size() + 1) * c);
  return sign_changes(slope);
}

PolyModel::Turn PolyModel::external(bool ascending) const {
  return ascending ? Turn{true, x_low_, y_low_} : Turn{false, x_high_, y_high_};
}

ModelMembers PolyModel::members() const {
  return {{"x_low", x_low_},
          {"x_high", x_high_},
          {"y_low", y_low_},
          {"y_high", y_high_},
          {"a", std::vector(p_.a.begin(), p_.a.end())},
          {"b", std::vector(p_.b.begin(), p_.b.end())}};
}

std::unique_ptr<HysteresisModel> PolyModel::from(const ModelSource& source) {
  PolyParameters polynomials;
  const auto take = [&](const char* name, std::span<double> into) {
    const std::vector<double> numbers = source.numbers(name);
    if (numbers.size() != into.size())
      throw std::invalid_argument(std::string("model: \"") + name + "\" does not hold 7 numbers");
    std::ranges::copy(numbers, into.begin());
  };
  take("a", polynomials.a);
  take("b", polynomials.b);
  return std::make_unique<PolyModel>(polynomials, source.number("x_low"), source.number("x_high"),
                                     source.number("y_low"), source.number("y_high"));
}

}  // namespace tactbench::analysis
