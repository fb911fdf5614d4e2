#include "analysis/compensate/curves.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

namespace {

using Film = PreisachCurve::Film;
// A piece of a branch that rises by less, or by nothing once its corner's output is added, is a step: no slope.
constexpr double kLeastRise = 1e-20;

// The last k <= most <= n for which `holds` is true; it is true up to k and false beyond. 0 if it is never true.
template <class Holds>
std::size_t last_that(std::size_t most, const Holds& holds) {
  std::size_t low = 0, high = most + 1;  // holds below, not at
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

// The piece in which the branch from (x0, u0) has output u; beyond the branch's end a constant one.
CurvePiece piece_of(const Film& e, bool rises, double x0, double u0, double u) {
  const std::size_t place = interval_of(x0, e.n);
  const double share = x0 - static_cast<double>(place), sign = rises ? 1.0 : -1.0, way = sign * (u - u0);
  // From (xa, ea) to (xb, eb), ea <= eb: Everett's function on the way from the corner.
  const auto between = [&](double xa, double ea, double xb, double eb) {
    const double ua = u0 + sign * ea, ub = u0 + sign * eb;
    const double slope = sign * (ub - ua) > kLeastRise ? (xb - xa) / (ub - ua) : 0.0;
    return CurvePiece{std::min(ua, ub), std::max(ua, ub), ua, xa, slope};
  };
  const auto constant = [&](double from, double x, bool below) {
    return below ? CurvePiece{-kFarOutput, from, from, x, 0.0} : CurvePiece{from, kFarOutput, from, x, 0.0};
  };
  if (way < 0.0) return constant(u0, x0, rises);
  if (rises) {
    const std::size_t j = place;
    const auto line = [&](std::size_t i) { return e.at(i, j) + share * (e.at(i, j + 1) - e.at(i, j)); };  // i > j
    if (way > line(e.n)) return constant(u0 + line(e.n), static_cast<double>(e.n), false);
    // The last i with line(i) < way, or j.
    const std::size_t low = j + last_that(e.n - 1 - j, [&](std::size_t off) { return line(j + off) < way; });
    const auto here = static_cast<double>(low);
    if (low == j) return between(x0, 0.0, here + 1.0, line(j + 1));
    const double kink = e.at(low, j + 1) + (e.at(low + 1, j + 1) - e.at(low, j + 1)) * share +
                        (e.at(low, j) - e.at(low, j + 1)) * (1.0 - share);
    return way <= kink ? between(here, line(low), here + share, kink)
                       : between(here + share, kink, here + 1.0, line(low + 1));
  }
  const std::size_t i = place;
  const auto line = [&](std::size_t j) { return e.at(i, j) + share * (e.at(i + 1, j) - e.at(i, j)); };  // j <= i
  if (way > line(0)) return constant(u0 - line(0), 0.0, true);
  // The last j with line(j) >= way.
  const std::size_t low = last_that(i, [&](std::size_t j) { return line(j) >= way; });
  const auto here = static_cast<double>(low);
  if (low == i) return between(x0, 0.0, here, line(i));
  const double kink = e.at(i, low + 1) + (e.at(i + 1, low + 1) - e.at(i, low + 1)) * share +
                      (e.at(i, low) - e.at(i, low + 1)) * (1.0 - share);
  return way >= kink ? between(here + share, kink, here, line(low))
                     : between(here + 1.0, line(low + 1), here + share, kink);
}

}  // namespace

// Sums of weights are rounded: equal ones may differ slightly, but the table must not fall.
std::shared_ptr<const Film> PreisachCurve::film_of(const PreisachModel& model, const Divider& divider) {
  auto film = std::make_shared<Film>();
  const std::size_t n = model.intervals();
  if (n < 1 || n > 100) throw std::invalid_argument("its intervals are not within 1 and 100");
  *film = {model.x_low(), model.x_high(), n, {0.0, divider.per_amplitude}, {}};
  const double step = (model.x_high() - model.x_low()) / static_cast<double>(n);
  const auto at = [&](std::size_t i) { return model.x_low() + step * static_cast<double>(i); };
  const auto place = [](std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; };
  film->everett.assign(place(n, n) + 1, 0.0);
  for (std::size_t i = 1; i <= n; ++i)
    for (std::size_t j = i; j-- > 0;)
      film->everett[place(i, j)] =
          std::max({model.everett(at(i), at(j)), film->everett[place(i - 1, j)], film->everett[place(i, j + 1)]});
  if (film->divider.output(film->top()) * divider.per_amplitude > Divider::kMost)
    throw std::invalid_argument("its full output exceeds the limit of its divider");
  return film;
}

CurvePiece PreisachCurve::piece(const Way& way, double at) const {
  const Way on = branch_at(way, at);
  CurvePiece piece = piece_of(*film_, on.rises(), on.corner.x, on.corner.u, at);
  // The next corner erases it.
  if (on.rises() && on.below >= 2) piece.high = std::min(piece.high, corners_[on.below - 1].u);
  if (!on.rises() && on.below >= 3) piece.low = std::max(piece.low, corners_[on.below - 1].u);
  return piece;
}

}  // namespace tactbench::analysis
