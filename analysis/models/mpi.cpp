#include "analysis/models/mpi.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/models/invert.h"
#include "analysis/models/play_operators.h"

namespace tactbench::analysis {
namespace {

class MpiState final : public ModelState {
 public:
  explicit MpiState(const MpiModel& model) : model_(&model) {}
  void reset() override {
    u_ = 0.0;
    operators_ = {};
  }
  [[nodiscard]] double output_at(double x) const override { return output(share_of(x)); }
  [[nodiscard]] double input_at(double y) const override {
    const double here = model_->output(operators_, u_);
    double u = u_;
    if (y != here) {
      const std::vector<double> way = model_->monotone_pieces(operators_, u_, y > here ? 1.0 : 0.0);
      u = first_crossing([&](double at) { return output(at); }, way, y);
    }
    return model_->x_low() + u * (model_->x_high() - model_->x_low());
  }
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<MpiState>(*this); }
  void go(double x) override {
    if (!std::isfinite(x)) throw std::invalid_argument("MPI: the input is not a finite number");
    u_ = share_of(x);
    operators_ = MpiModel::moved(operators_, u_);
  }

 private:
  [[nodiscard]] double share_of(double x) const {
    return std::clamp((x - model_->x_low()) / (model_->x_high() - model_->x_low()), 0.0, 1.0);
  }
  [[nodiscard]] double output(double u) const { return model_->output(MpiModel::moved(operators_, u), u); }
  const MpiModel* model_;
  double u_ = 0.0;
  MpiModel::Operators operators_{};
};

}  // namespace

MpiModel::MpiModel(const MpiParameters& parameters, double x_low, double x_high, double y_low)
    : p_(parameters), x_low_(x_low), x_high_(x_high), y_low_(y_low), b_(densities(p_.tau)) {
  for (const double value : {x_low, x_high, y_low, p_.a1, p_.a2, p_.a3, p_.rho, p_.tau})
    if (!std::isfinite(value)) throw std::invalid_argument("MPI model: a number is not finite");
  if (x_low >= x_high) throw std::invalid_argument("MPI model: \"x_low\" is not below \"x_high\"");
  if (p_.rho < 0.0) throw std::invalid_argument("MPI model: \"rho\" is negative");
  const double span = x_high - x_low;
  c1_ = p_.a1 * span;
  c2_ = p_.a2 * span * span;
  c3_ = p_.a3 * span * span * span;
  for (double& b : b_) b *= p_.rho;
}

std::vector<ModelParameter> MpiModel::parameters() const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  return {{"a1", p_.a1, "y/x", -kNone, kNone},
          {"a2", p_.a2, "y/x^2", -kNone, kNone},
          {"a3", p_.a3, "y/x^3", -kNone, kNone},
          {"rho", p_.rho, "y", 0.0, kNone},
          {"tau", p_.tau, "1", -kMpiTau, kMpiTau}};
}

// The input scaled (2), ten operators (a subtraction, two comparisons, a multiply-add; the first is the input itself),
// the cubic (6) and the offset.
int MpiModel::operations_per_sample() const { return 2 + 9 * 5 + 2 + 6 + 1; }

std::unique_ptr<ModelState> MpiModel::state() const { return std::make_unique<MpiState>(*this); }

MpiModel::Operators MpiModel::densities(double tau) {
  Operators densities;
  for (std::size_t i = 0; i < densities.size(); ++i) {
    const double beyond = static_cast<double>(i) - 1.0;               // n r_i - 1
    densities[i] = std::exp(-tau * beyond * beyond) / kMpiOperators;  // (45) times the spacing
  }
  return densities;
}

MpiModel::Operators MpiModel::moved(const Operators& before, double u) {
  Operators now;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] = one_sided_play(u, threshold(i), before[i]);
  return now;
}

double MpiModel::output(const Operators& operators, double u) const {
  double y = y_low_ + ((c3_ * u + c2_) * u + c1_) * u;  // (46)
  for (std::size_t i = 0; i < operators.size(); ++i) y += b_[i] * operators[i];
  return y;
}

std::vector<double> MpiModel::monotone_pieces(const Operators& operators, double u, double end) const {
  const bool up = end > u;
  // An operator starts to move at the end of its band; between two such places the output is a cubic.
  std::vector<double> starts;
  for (std::size_t i = 0; i < operators.size(); ++i) {
    const double at = up ? operators[i] + threshold(i) : operators[i];
    if (up ? at > u && at < end : at < u && at > end) starts.push_back(at);
  }
  starts.push_back(end);
  std::ranges::sort(starts, [up](double a, double b) { return up ? a < b : a > b; });
  std::vector<double> pieces{u};
  double from = u;
  for (const double to : starts) {
    const double middle = 0.5 * (from + to);
    double slope = c1_;
    for (std::size_t i = 0; i < operators.size(); ++i)
      if (up ? operators[i] + threshold(i) < middle : operators[i] > middle) slope += b_[i];
    // 3 c3 u^2 + 2 c2 u + slope = 0.
    const double discriminant = c2_ * c2_ - 3.0 * c3_ * slope;
    if (discriminant > 0.0) {
      const double q = -(c2_ + std::copysign(std::sqrt(discriminant), c2_));
      double first = q / (3.0 * c3_), second = slope / q;  // infinite or NaN when there is none: no piece holds it
      if (up ? first > second : first < second) std::swap(first, second);
      for (const double at : {first, second})
        if (up ? at > from && at < to : at < from && at > to) pieces.push_back(at);
    }
    pieces.push_back(to);
    from = to;
  }
  return pieces;
}

ModelMembers MpiModel::members() const { return range_and_parameters(*this, y_low_); }

std::unique_ptr<HysteresisModel> MpiModel::from(const ModelSource& source) {
  const auto p = [&](const char* name) { return source.parameter(name); };
  return std::make_unique<MpiModel>(MpiParameters{p("a1"), p("a2"), p("a3"), p("rho"), p("tau")},
                                    source.number("x_low"), source.number("x_high"), source.number("y_low"));
}

}  // namespace tactbench::analysis
