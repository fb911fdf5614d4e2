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

ElamPiecedCurve::ElamPiecedCurve(const ElamModel& model, const ElamPieces& pieces, bool ascending, double x_turn,
                                 double y_turn)
    : curve_(model, ascending, x_turn, y_turn) {
  const double from_end = ascending ? curve_.turn_x() - model.x0() : model.xu() - curve_.turn_x();
  const bool outer = from_end <= kOuterShare * (model.xu() - model.x0());
  if (pieces.splits() == 1 || (model.options.exact_outer && outer)) return;
  const double xs = curve_.split_x(), ys = curve_.split_y(), x = curve_.turn_x(), y = curve_.turn_y();
  if (ascending) {
    plain_[0] = sized_[0] = x;
    divide(pieces.ascending_low, xs, [&](double share) { return curve_.input(y + (ys - y) * share); });
    divide(pieces.ascending_high, model.xu(),
           [&](double share) { return curve_.input(ys + (model.yu() - ys) * share); });
  } else {
    plain_[0] = sized_[0] = model.y0();
    divide(pieces.descending_low, ys,
           [&](double share) { return curve_.output(model.x0() + (xs - model.x0()) * share); });
    divide(pieces.descending_high, y, [&](double share) { return curve_.output(xs + (x - xs) * share); });
  }
}

// Adds the knots of the next side, which ends at `end`; place(share) is an inner one's place on the paper's curve.
template <class Place>
void ElamPiecedCurve::divide(const std::vector<double>& logs, double end, const Place& place) {
  const std::size_t first = last_, count = logs.size() + 1;
  const double start = plain_[first];
  for (std::size_t i = 1; i <= count; ++i) {
    const double before = plain_[last_], weight = i == 1 ? 1.0 : std::exp(logs[i - 2]);
    const double at = i == count ? end : place(static_cast<double>(i) / static_cast<double>(count));
    plain_[last_ + 1] = std::clamp(at, before, std::max(before, end));
    sized_[last_ + 1] = sized_[last_] + weight * (plain_[last_ + 1] - before);
    ++last_;
  }
  const double size = sized_[last_] - start;
  for (std::size_t i = first + 1; i < last_ && size > 0.0; ++i)
    sized_[i] = std::min(start + (sized_[i] - start) * ((end - start) / size), end);
  sized_[last_] = plain_[last_];
}

double ElamPiecedCurve::mapped(double value, const Knots& from, const Knots& to) const {
  std::size_t i = 1;
  while (i < last_ && value > from[i]) ++i;
  if (value >= from[i]) return to[i];
  if (value <= from[i - 1]) return to[i - 1];
  return to[i - 1] + (to[i] - to[i - 1]) * ((value - from[i - 1]) / (from[i] - from[i - 1]));
}

double ElamPiecedCurve::output(double x) const {
  if (last_ == 0) return curve_.output(x);
  return ascending() ? curve_.output(mapped(x, sized_, plain_)) : mapped(curve_.output(x), plain_, sized_);
}

double ElamPiecedCurve::input(double y) const {
  if (last_ == 0) return curve_.input(y);
  return ascending() ? mapped(curve_.input(y), plain_, sized_) : curve_.input(mapped(y, sized_, plain_));
}

}  // namespace tactbench::analysis
