#include "analysis/compensate/elam_curve.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {
namespace {

constexpr double kScalableRise = 1e-6;  // of the span: a curve that rises less cannot be scaled to others: linear [A12]

}  // namespace

ElamStack::Target ElamStack::target(const ElamCurve& curve, double x_end, double y_end) const {
  Target t{curve, x_end, y_end};
  // A start measured beyond the end: flat, never in the wrong direction.
  t.y_from = curve.ascending() ? std::min(curve.turn_y(), y_end) : std::max(curve.turn_y(), y_end);
  t.base = curve.output(curve.turn_x());
  const double rise = curve.output(x_end) - t.base;
  t.straight = std::abs(rise) <= kScalableRise * top();
  t.per = t.y_from == y_end || t.straight ? 0.0 : rise / (y_end - t.y_from);
  return t;
}

void ElamStack::start(bool from_top) {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  targets_[0] = from_top ? target({*model_, false, xu, yu}, x0, y0) : target({*model_, true, x0, y0}, xu, yu);
  below_ = 0;
}

ElamStack::Branch ElamStack::branch_at(const Target& last, std::size_t below, double y) const {
  Branch at{&last, below};
  while (at.below >= 2 && (at.target->curve.ascending() ? y > at.target->y_end : y < at.target->y_end))
    at = {&targets_[at.below - 2], at.below - 2};
  return at;
}

CurvePiece ElamStack::piece_of(const Target& t, double y) {
  const bool rises = t.curve.ascending();
  const double low = std::min(t.y_from, t.y_end), high = std::max(t.y_from, t.y_end);
  const double x_low = rises ? t.curve.turn_x() : t.x_end, x_high = rises ? t.x_end : t.curve.turn_x();
  if (y <= low) return {-kFarOutput, low, low, x_low, 0.0};
  if (y >= high) return {high, kFarOutput, high, x_high, 0.0};
  if (t.straight) return {low, high, low, x_low, (x_high - x_low) / (high - low)};
  CurvePiece p = t.curve.piece(t.base + (y - t.y_from) * t.per);
  const auto back = [&](double of_curve) { return t.y_from + (of_curve - t.base) / t.per; };
  return {std::clamp(back(p.low), low, y), std::clamp(back(p.high), y, high), back(p.y_a), p.x_a, p.slope * t.per};
}

CurvePiece ElamStack::piece_of(const Target& last, std::size_t below, double y) const {
  const double y0 = model_->y0();
  const Branch at = branch_at(last, below, y + y0);
  const Target& own = *at.target;
  CurvePiece piece = piece_of(own, y + y0);
  // Beyond its end the loop is closed and another branch continues.
  if (at.below >= 2 && own.curve.ascending()) piece.high = std::min(piece.high, own.y_end);
  if (at.below >= 2 && !own.curve.ascending()) piece.low = std::max(piece.low, own.y_end);
  for (double* const output : {&piece.low, &piece.high, &piece.y_a}) *output -= y0;
  return piece;
}

ElamStack::Way ElamStack::back_from(double y, const CurvePiece& on) const {
  const double x0 = model_->x0(), xu = model_->xu(), y0 = model_->y0(), yu = model_->yu();
  const auto [left, below] = branch_at(targets_[below_], below_, y + y0);
  const Target& last = *left;
  const double x = std::clamp(on.along(y), x0, xu);
  y += y0;
  const bool rises = !last.curve.ascending();
  // At an end of the range older turning points are forgotten, and a branch that left an end goes to the output of the
  // fitted loop, not to the measured output, because otherwise a drifted gain would count as fitted.
  const bool ends = rises ? x <= x0 : x >= xu;
  const bool to_end = ends || (rises ? last.curve.turn_x() >= xu : last.curve.turn_x() <= x0);
  double split = x;
  if (!rises) split += std::clamp(2.0 - (yu - y) / (kDriftShare * top()), 0.0, 1.0) * (xu - x);
  const ElamCurve curve(*model_, rises, x, y, split);
  const std::size_t room = below + 1 < kMost ? below + 1 : below - 1;
  return {to_end ? rises ? target(curve, xu, yu) : target(curve, x0, y0)
                 : target(curve, last.curve.turn_x(), last.curve.turn_y()),
          ends ? 0 : room};
}

}  // namespace tactbench::analysis
