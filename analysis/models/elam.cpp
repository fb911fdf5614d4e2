#include "analysis/models/elam.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

bool saturated(const ElamModel& model, double rise) { return rise <= kSaturatedShare * (model.yu() - model.y0()); }

}  // namespace

ElamCurve::ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn)
    : ElamCurve(model, ascending, x_turn, y_turn, x_turn) {}

ElamCurve::ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn, double x_split_turn)
    : model_(&model), ascending_(ascending) {
  if (!std::isfinite(x_turn) || !std::isfinite(y_turn) || !std::isfinite(x_split_turn))
    throw std::invalid_argument("ELAM curve: the turning point is not finite");
  const double x0 = model.x0(), xu = model.xu(), y0 = model.y0(), yu = model.yu();
  const ElamParameters& p = model.parameters;
  x_turn_ = std::clamp(x_turn, x0, xu);
  y_turn_ = std::max(y_turn, y0);
  if (ascending) y_turn_ = std::min(y_turn_, yu);
  const bool exact = model.options.exact_outer;
  const double near = kOuterShare * (xu - x0);
  if (ascending) {
    const double length = xu - x_turn_;
    xs_ = x_turn_ + std::clamp(p.alpha_a1 * length + p.alpha_a0, 0.0, 1.0) * length;  // (21)
    ys_ = y_turn_ + p.beta_a * (yu - y_turn_);                                        // (22)
    xsp_ = model.ascending.inverse(ys_);
    xmp_ = model.ascending.inverse(y_turn_);
    ysp_ = ys_;
    // An external branch follows P_a itself exactly when its split lies on P_a.
    if (exact && x_turn_ - x0 <= near) xs_ = std::max(xsp_, x_turn_);
  } else {
    const double x_split = std::clamp(x_split_turn, x_turn_, xu);
    xs_ = std::min(x0 + p.alpha_d * (x_split - x0), x_turn_);  // (14)
    xsp_ = xs_;
    xmp_ = x_turn_;
    ysp_ = model.descending(xs_);
    // (15), or P_d's own share there.
    const double share = exact && xu - x_split <= near ? (ysp_ - y0) / (yu - y0) : p.beta_d;
    ys_ = y0 + share * (y_turn_ - y0);
  }
}

double ElamCurve::output(double x) const { return ascending_ ? ascending_output(x) : descending_output(x); }
double ElamCurve::input(double y) const { return ascending_ ? ascending_input(y) : descending_input(y); }

double ElamCurve::descending_output(double x) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const PatternCurve& pattern = model_->descending;
  if (x >= x_turn_) return y_turn_;
  if (x <= x0) return y0;
  if (x >= xs_) {
    const double share = (x - xs_) / (x_turn_ - xs_);
    if (saturated(*model_, yu - ysp_)) return ys_ + (y_turn_ - ys_) * share;
    const double xp = xs_ + (xu - xs_) * share;                           // (16)
    return ys_ + (y_turn_ - ys_) * ((pattern(xp) - ysp_) / (yu - ysp_));  // (17)
  }
  if (saturated(*model_, ysp_ - y0)) return y0 + (ys_ - y0) * ((x - x0) / (xs_ - x0));
  return y0 + (ys_ - y0) * ((pattern(x) - y0) / (ysp_ - y0));  // (18), (19)
}

double ElamCurve::descending_input(double y) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const PatternCurve& pattern = model_->descending;
  if (y >= y_turn_) return x_turn_;
  if (y <= y0) return x0;
  if (y >= ys_) {
    const double share = (y - ys_) / (y_turn_ - ys_);
    if (saturated(*model_, yu - ysp_)) return xs_ + (x_turn_ - xs_) * share;
    const double xp = pattern.inverse(ysp_ + (yu - ysp_) * share);                       // (31)
    return std::clamp(xs_ + (x_turn_ - xs_) * ((xp - xs_) / (xu - xs_)), xs_, x_turn_);  // (32)
  }
  const double share = (y - y0) / (ys_ - y0);
  if (saturated(*model_, ysp_ - y0)) return x0 + (xs_ - x0) * share;
  return std::min(pattern.inverse(y0 + (ysp_ - y0) * share), xs_);  // (33) as [A5], (34)
}

double ElamCurve::ascending_output(double x) const {
  const double xu = model_->xu(), yu = model_->yu();
  const PatternCurve& pattern = model_->ascending;
  if (x <= x_turn_) return y_turn_;
  if (x >= xu) return yu;
  if (x <= xs_) return pattern(xmp_ + (xsp_ - xmp_) * ((x - x_turn_) / (xs_ - x_turn_)));  // (25), (26)
  return pattern(xsp_ + (xu - xsp_) * ((x - xs_) / (xu - xs_)));                           // (23), (24)
}

double ElamCurve::ascending_input(double y) const {
  const double xu = model_->xu(), yu = model_->yu();
  const PatternCurve& pattern = model_->ascending;
  if (y <= y_turn_) return x_turn_;
  if (y >= yu) return xu;
  const double xp = pattern.inverse(y);  // (35), (37)
  if (y <= ys_) {
    if (xsp_ <= xmp_) return xs_;
    return std::clamp(x_turn_ + (xs_ - x_turn_) * ((xp - xmp_) / (xsp_ - xmp_)), x_turn_, xs_);  // (36)
  }
  if (xu <= xsp_) return xu;
  return std::clamp(xs_ + (xu - xs_) * ((xp - xsp_) / (xu - xsp_)), xs_, xu);  // (38)
}

}  // namespace tactbench::analysis
