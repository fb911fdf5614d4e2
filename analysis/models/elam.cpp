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

CurvePiece ElamCurve::piece(double y) const { return ascending_ ? ascending_piece(y) : descending_piece(y); }

double ElamCurve::input(double y) const {
  const double low = ascending_ ? x_turn_ : model_->x0(), high = ascending_ ? model_->xu() : x_turn_;
  return std::clamp(piece(y).along(y), low, high);
}

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

CurvePiece ElamCurve::descending_piece(double y) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const PatternCurve& pattern = model_->descending;
  if (y >= y_turn_) return {y_turn_, kFarOutput, y_turn_, x_turn_, 0.0};
  if (y <= y0) return {-kFarOutput, y0, y0, x0, 0.0};
  if (y >= ys_) {
    const double rise = yu - ysp_;
    if (saturated(*model_, rise)) return {ys_, y_turn_, ys_, xs_, (x_turn_ - xs_) / (y_turn_ - ys_)};
    const double per = rise / (y_turn_ - ys_), scale = (x_turn_ - xs_) / (xu - xs_);  // (31), (32)
    const CurvePiece p = pattern.piece(ysp_ + per * (y - ys_));
    const double from = std::max(p.low, ysp_);
    return {std::min(ys_ + (from - ysp_) / per, y), std::clamp(ys_ + (p.high - ysp_) / per, y, y_turn_),
            ys_ + (from - ysp_) / per, xs_ + scale * (p.along(from) - xs_), scale * p.slope * per};
  }
  if (saturated(*model_, ysp_ - y0)) return {y0, ys_, y0, x0, (xs_ - x0) / (ys_ - y0)};
  const double per = (ysp_ - y0) / (ys_ - y0);  // (33) as [A5], (34)
  const CurvePiece p = pattern.piece(y0 + per * (y - y0));
  return {std::min(y0 + (p.low - y0) / per, y), std::clamp(y0 + (p.high - y0) / per, y, ys_), y0 + (p.low - y0) / per,
          p.x_a, p.slope * per};
}

double ElamCurve::ascending_output(double x) const {
  const double xu = model_->xu(), yu = model_->yu();
  const PatternCurve& pattern = model_->ascending;
  if (x <= x_turn_) return y_turn_;
  if (x >= xu) return yu;
  if (x <= xs_) return pattern(xmp_ + (xsp_ - xmp_) * ((x - x_turn_) / (xs_ - x_turn_)));  // (25), (26)
  return pattern(xsp_ + (xu - xsp_) * ((x - xs_) / (xu - xs_)));                           // (23), (24)
}

CurvePiece ElamCurve::ascending_piece(double y) const {
  const double xu = model_->xu(), yu = model_->yu();
  if (y <= y_turn_) return {-kFarOutput, y_turn_, y_turn_, x_turn_, 0.0};
  if (y >= yu) return {yu, kFarOutput, yu, xu, 0.0};
  const bool lower = y <= ys_;
  if (lower && xsp_ <= xmp_) return {y_turn_, ys_, ys_, xs_, 0.0};
  if (!lower && xu <= xsp_) return {ys_, yu, ys_, xu, 0.0};
  const CurvePiece p = model_->ascending.piece(y);  // (35), (37)
  const double from = std::max(p.low, lower ? y_turn_ : ys_), to = std::min(p.high, lower ? ys_ : yu);
  const double scale = lower ? (xs_ - x_turn_) / (xsp_ - xmp_) : (xu - xs_) / (xu - xsp_);
  const double x = lower ? x_turn_ + scale * (p.along(from) - xmp_)  // (36)
                         : xs_ + scale * (p.along(from) - xsp_);     // (38)
  return {std::min(from, y), std::max(to, y), from, x, scale * p.slope};
}

}  // namespace tactbench::analysis
