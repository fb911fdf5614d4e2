#include "analysis/compensate/composed_curve.h"

#include <algorithm>
#include <cmath>

#include "analysis/models/interval.h"

namespace tactbench::analysis {

// Halving without branches: outputs carry noise, so branches on them could not be predicted.
std::size_t TaxelPattern::Side::piece(double at, std::size_t near) const {
  if (y[near] <= at) {
    if (at < y[near + 1]) return near;
    if (near + 2 < y.size() && at < y[near + 2]) return near + 1;
  } else if (near > 0 && y[near - 1] <= at) {
    return near - 1;
  }
  const double* first = y.data();
  for (std::size_t left = y.size() - 1; left > 1;) {
    const std::size_t half = left / 2;
    first = first[half] <= at ? first + half : first;
    left -= half;
  }
  return static_cast<std::size_t>(first - y.data());
}

double TaxelPattern::output(const Side& side, double x_at) const {
  if (x_at <= x.front()) return 0.0;
  if (x_at >= x.back()) return span;
  // Grids are uniform or nearly so: the proportional guess is right or one off.
  const std::size_t last = x.size() - 2;
  const double share = (x_at - x.front()) / (x.back() - x.front());
  std::size_t i = interval_of(share * static_cast<double>(last + 1), last + 1);
  while (i > 0 && x_at < x[i]) --i;
  while (i < last && x_at >= x[i + 1]) ++i;
  return side.y[i] + (side.y[i + 1] - side.y[i]) * ((x_at - x[i]) / (x[i + 1] - x[i]));
}

double TaxelPattern::input(const Side& side, double y_at, std::size_t& near) const {
  if (y_at <= 0.0) return x.front();
  if (y_at >= span) return x.back();
  near = side.piece(y_at, near);
  return x[near] + (y_at - side.y[near]) * side.slope[near];
}

ComposedCurve curve_from(const TaxelPattern& p, bool ascending, double x_turn, double y_turn, double x_split_turn,
                         const ComposedCurve& near) {
  const double x0 = p.x.front(), xu = p.x.back(), outer = kOuterShare * (xu - x0);
  const ElamParameters& own = p.parameters;
  ComposedCurve c;
  c.ascending = ascending;
  c.x_turn = std::clamp(x_turn, x0, xu);
  c.y_turn = std::max(y_turn, 0.0);
  if (ascending) {
    c.y_turn = std::min(c.y_turn, p.span);
    const double length = xu - c.x_turn;
    c.xs = c.x_turn + std::clamp(own.alpha_a1 * length + own.alpha_a0, 0.0, 1.0) * length;  // (21)
    c.ysp = c.ys = c.y_turn + own.beta_a * (p.span - c.y_turn);                             // (22)
    c.turn_near = near.turn_near;
    c.split_near = near.split_near;
    c.xsp = p.input(p.ascending, c.ys, c.split_near);
    c.xmp = p.input(p.ascending, c.y_turn, c.turn_near);
    if (p.exact_outer && c.x_turn - x0 <= outer) c.xs = std::max(c.xsp, c.x_turn);
    return c;
  }
  const double x_split = std::clamp(x_split_turn, c.x_turn, xu);
  c.xsp = c.xs = std::min(x0 + own.alpha_d * (x_split - x0), c.x_turn);  // (14)
  c.xmp = c.x_turn;
  c.turn_near = p.x.size() - 2;  // the pattern's top for every turn
  c.ysp = p.output(p.descending, c.xs);
  c.ys = (p.exact_outer && xu - x_split <= outer ? c.ysp / p.span : own.beta_d) * c.y_turn;  // (15)
  return c;
}

// The drift allowance is TaxelCompensator's: near yu the split is that of a turn at xu.
ComposedCurve reversed(const TaxelPattern& p, const ComposedCurve& curve, double y) {
  return reversed(p, curve, y, input_at(p, curve, y));
}

ComposedCurve reversed(const TaxelPattern& p, const ComposedCurve& curve, double y, double x,
                       const ComposedCurve& near) {
  if (!curve.ascending) return curve_from(p, true, x, y, x, near);
  const double converged = p.drift > 0.0 ? std::clamp(2.0 - (p.span - y) / p.drift, 0.0, 1.0) : 0.0;
  return curve_from(p, false, x, y, x + converged * (p.x.back() - x));
}

double input_at(const TaxelPattern& p, const ComposedCurve& c, double y, std::size_t near) {
  const double x0 = p.x.front(), xu = p.x.back();
  if (c.ascending) {
    if (y <= c.y_turn) return c.x_turn;
    if (y >= p.span) return xu;
    const double xp = p.input(p.ascending, y, near);  // (35), (37)
    if (y <= c.ys)
      return c.xsp <= c.xmp
                 ? c.xs
                 : std::clamp(c.x_turn + (c.xs - c.x_turn) * ((xp - c.xmp) / (c.xsp - c.xmp)), c.x_turn, c.xs);  // (36)
    return xu <= c.xsp ? xu : std::clamp(c.xs + (xu - c.xs) * ((xp - c.xsp) / (xu - c.xsp)), c.xs, xu);          // (38)
  }
  if (y >= c.y_turn) return c.x_turn;
  if (y <= 0.0) return x0;
  if (y >= c.ys) {
    const double share = (y - c.ys) / (c.y_turn - c.ys), rise = p.span - c.ysp;
    if (rise <= p.saturated) return c.xs + (c.x_turn - c.xs) * share;
    const double xp = p.input(p.descending, c.ysp + rise * share, near);                        // (31)
    return std::clamp(c.xs + (c.x_turn - c.xs) * ((xp - c.xs) / (xu - c.xs)), c.xs, c.x_turn);  // (32)
  }
  if (c.ysp <= p.saturated) return x0 + (c.xs - x0) * (y / c.ys);
  return std::min(p.input(p.descending, c.ysp * (y / c.ys), near), c.xs);  // (33) as [A5], (34)
}

double sensitivity(const TaxelPattern& p, const ComposedCurve& curve, double y, double x, std::size_t near) {
  if (p.step <= 0.0) return 0.0;
  return std::max(x - input_at(p, curve, y - p.step, near), input_at(p, curve, y + p.step, near) - x) / p.step;
}

// On the other side the reverse curve ends at its turn.
double reverse_sensitivity(const TaxelPattern& p, const ComposedCurve& curve, double y, double x,
                           const ComposedCurve& near) {
  if (p.step <= 0.0) return 0.0;
  const ComposedCurve back = reversed(p, curve, y, x, near);
  return std::abs(x - input_at(p, back, curve.ascending ? y - p.step : y + p.step)) / p.step;
}

namespace {

CurvePiece rising_piece(const TaxelPattern& p, const ComposedCurve& c, double y, std::size_t near) {
  const TaxelPattern::Side& side = p.ascending;
  const double xu = p.x.back();
  if (y <= c.y_turn) return {-kFar, c.y_turn, c.x_turn, 0.0, index_below(p), near};
  if (y > p.span) return {p.span, kFar, xu, 0.0, index_above(p), near};
  const bool lower = y <= c.ys;
  if (lower && c.xsp <= c.xmp) return {c.y_turn, c.ys, c.xs, 0.0, 0, near};
  if (!lower && xu <= c.xsp) return {c.ys, p.span, xu, 0.0, p.x.size() - 1, near};
  const std::size_t i = side.piece(y, near);
  const double from = std::max(side.y[i], lower ? c.y_turn : c.ys), xp = p.x[i] + (from - side.y[i]) * side.slope[i];
  if (lower) {
    const double scale = (c.xs - c.x_turn) / (c.xsp - c.xmp);  // (36)
    return {from, std::min(side.y[i + 1], c.ys), c.x_turn + scale * (xp - c.xmp), scale * side.slope[i], i, i};
  }
  const double scale = (xu - c.xs) / (xu - c.xsp);  // (38)
  return {from, side.y[i + 1], c.xs + scale * (xp - c.xsp), scale * side.slope[i], i + 1, i};
}

CurvePiece falling_piece(const TaxelPattern& p, const ComposedCurve& c, double y, std::size_t near) {
  const TaxelPattern::Side& side = p.descending;
  const double x0 = p.x.front(), xu = p.x.back();
  if (y > c.y_turn || (y == c.y_turn && c.y_turn <= c.ys)) return {c.y_turn, kFar, c.x_turn, 0.0, index_above(p), near};
  if (y <= 0.0) return {-kFar, 0.0, x0, 0.0, index_below(p), near};
  if (y > c.ys) {
    const double rise = p.span - c.ysp;
    if (rise <= p.saturated)  // [A12]
      return {c.ys, c.y_turn, c.xs, (c.x_turn - c.xs) / (c.y_turn - c.ys), p.x.size() - 1, near};
    const double per = rise / (c.y_turn - c.ys), scale = (c.x_turn - c.xs) / (xu - c.xs);  // (31), (32)
    const std::size_t i = side.piece(c.ysp + per * (y - c.ys), near);
    const double from = std::max(side.y[i], c.ysp), xp = p.x[i] + (from - side.y[i]) * side.slope[i];
    return {c.ys + (from - c.ysp) / per,
            std::min(c.ys + (side.y[i + 1] - c.ysp) / per, c.y_turn),
            c.xs + scale * (xp - c.xs),
            scale * side.slope[i] * per,
            i + 1,
            i};
  }
  if (c.ysp <= p.saturated) return {0.0, c.ys, x0, (c.xs - x0) / c.ys, 0, near};
  const double per = c.ysp / c.ys;  // (33) as [A5], (34)
  const std::size_t i = side.piece(per * y, near);
  return {side.y[i] / per, std::min(side.y[i + 1] / per, c.ys), p.x[i], side.slope[i] * per, i, i};
}

}  // namespace

CurvePiece piece_at(const TaxelPattern& p, const ComposedCurve& c, double y, std::size_t near) {
  return c.ascending ? rising_piece(p, c, y, near) : falling_piece(p, c, y, near);
}

}  // namespace tactbench::analysis
