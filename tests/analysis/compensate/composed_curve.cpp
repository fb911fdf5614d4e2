// The fast compensator's curves beside ELAM's own: splits, inverses, linear pieces and sensitivities on random taxels,
// with external branches by the formulas and on the pattern, from turns anywhere, at the ends and beyond them.
#include "analysis/compensate/composed_curve.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

TaxelPattern::Side side_like(const PatternCurve& curve) {
  TaxelPattern::Side side;
  const auto x = curve.x(), y = curve.y();
  for (std::size_t i = 0; i < y.size(); ++i) side.y.push_back(y[i] - y.front());
  for (std::size_t i = 0; i + 1 < y.size(); ++i) side.slope.push_back((x[i + 1] - x[i]) / (y[i + 1] - y[i]));
  return side;
}

// In volts, that is with a noise of 1 V.
TaxelPattern pattern_like(const ElamModel& model) {
  TaxelPattern p;
  p.x.assign(model.ascending.x().begin(), model.ascending.x().end());
  p.ascending = side_like(model.ascending);
  p.descending = side_like(model.descending);
  p.parameters = model.parameters;
  p.exact_outer = model.options.exact_outer;
  p.noise_v = 1.0;
  p.span = model.yu() - model.y0();
  p.drift = 0.01 * p.span;
  p.step = 0.004;
  p.saturated = kSaturatedShare * p.span;
  return p;
}

// Taxels of an array, of the paper's clipped loop, and with splits at the bounds of the search.
std::vector<ElamModel> curve_models() {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 3;
  std::vector<ElamModel> models = Array(options).taxels;
  models.push_back(model_of(paper_loop(), kPrinted));
  for (const ElamParameters& p : {ElamParameters{1.0, 1.0, 0.0, 1.0, 1.0}, ElamParameters{0.0, 0.0, 0.0, 0.0, 0.0},
                                  ElamParameters{0.5, 0.5, 0.01, 0.4, 0.5}, ElamParameters{0.3, 0.9, -0.02, 1.1, 0.2},
                                  ElamParameters{1.0, 0.5, 0.0, 1.0, 0.5}})
    models.push_back(model_of(paper_loop(), p));
  std::vector<ElamModel> both = models;
  for (ElamModel& model : models) model.options.exact_outer = !model.options.exact_outer;
  both.insert(both.end(), models.begin(), models.end());
  return both;
}

void check_like(const TaxelPattern& p, const ComposedCurve& fast, const ElamModel& model, const ElamCurve& plain) {
  const double y0 = model.y0();
  CHECK(fast.ascending == plain.ascending());
  CHECK(fast.x_turn == Approx(plain.turn_x()).margin(1e-9));
  CHECK(fast.y_turn == Approx(plain.turn_y() - y0).margin(1e-9));
  CHECK(fast.xs == Approx(plain.split_x()).margin(1e-9));
  CHECK(fast.ys == Approx(plain.split_y() - y0).margin(1e-9));
  CurvePiece last{-1.0, 0.0, 0.0, 0.0, 0, 0};
  for (int i = -10; i <= 110; ++i) {
    const double y = p.span * (0.01 * i + 0.00137), x = input_at(p, fast, y);
    if (std::abs(x - plain.input(y + y0)) > 1e-7) FAIL_CHECK("at " << y << " V " << x << " psi");
    for (const std::size_t near : {std::size_t{0}, p.x.size() / 2, p.x.size() - 2}) {
      const CurvePiece piece = piece_at(p, fast, y, near);
      if (!piece.holds(y)) FAIL_CHECK("at " << y << " V the piece is from " << piece.from << " to " << piece.to);
      if (std::abs(piece.along(y) - x) > 1e-7) FAIL_CHECK("at " << y << " V the piece gives " << piece.along(y));
      if (std::abs(input_at(p, fast, y, near) - x) > 1e-12) FAIL_CHECK("depends on where it began to search");
      // Pieces within the curve are counted by rising output; below and above it they have numbers of their own.
      const bool below = y <= (fast.ascending ? fast.y_turn : 0.0), above = y > (fast.ascending ? p.span : fast.y_turn);
      if (below && piece.index != index_below(p)) FAIL_CHECK("at " << y << " V not the place below the curve");
      if (above && piece.index != index_above(p)) FAIL_CHECK("at " << y << " V not the place above the curve");
      if (below || above) continue;
      if (piece.index >= p.x.size()) FAIL_CHECK("at " << y << " V no such piece");
      if (last.from >= 0.0 && (piece.index < last.index || (piece.index == last.index) != (piece.from == last.from)))
        FAIL_CHECK("at " << y << " V piece " << piece.index << " after " << last.index);
      last = piece;
    }
    const double s = p.step, steepest = std::max(x - input_at(p, fast, y - s), input_at(p, fast, y + s) - x) / s;
    if (std::abs(sensitivity(p, fast, y, x, 0) - steepest) > 1e-6) FAIL_CHECK("sensitivity at " << y << " V");
  }
}

}  // namespace

TEST_CASE("fast curves: rising from anywhere, they are ELAM's") {
  for (const ElamModel& model : curve_models()) {
    const TaxelPattern p = pattern_like(model);
    for (const double x_turn : {-1.0, 0.0, 0.3, 0.59, 0.61, 7.0, 30.0, 45.5, 59.5, 60.0})
      for (const double share : {0.0, 0.3, 0.7, 0.99}) {
        const double y_turn = model.y0() + share * p.span;
        INFO("exact outer " << p.exact_outer << ", alpha_d " << model.parameters.alpha_d << ", from " << x_turn
                            << " psi, " << y_turn << " V");
        check_like(p, curve_from(p, true, x_turn, y_turn - model.y0(), x_turn), model,
                   ElamCurve(model, true, x_turn, y_turn));
      }
  }
}

TEST_CASE("fast curves: falling from anywhere, with the split of any turn above it, they are ELAM's") {
  for (const ElamModel& model : curve_models()) {
    const TaxelPattern p = pattern_like(model);
    for (const double x_turn : {0.5, 7.0, 30.0, 45.5, 59.39, 59.41, 60.0, 61.0})
      for (const double up : {0.0, 0.5, 1.0}) {
        const double x_split = std::min(x_turn, 60.0) + up * std::max(0.0, 60.0 - x_turn);
        const double y_turn = model.descending(std::min(x_turn, 60.0));
        INFO("exact outer " << p.exact_outer << ", alpha_d " << model.parameters.alpha_d << ", from " << x_turn
                            << " psi, " << y_turn << " V, split of " << x_split);
        check_like(p, curve_from(p, false, x_turn, y_turn - model.y0(), x_split), model,
                   ElamCurve(model, false, x_turn, y_turn, x_split));
      }
  }
}

TEST_CASE(
    "fast curves: the way back from a rise has the split of the top within a hundredth of it, fading to twice that") {
  const ElamModel model = curve_models()[1];
  TaxelPattern p = pattern_like(model);
  const ComposedCurve rise = curve_from(p, true, 0.0, 0.0, 0.0);
  for (const auto& [below, converged] :
       {std::pair{0.0, 1.0}, {0.99, 1.0}, {1.25, 0.75}, {1.75, 0.25}, {2.01, 0.0}, {9.0, 0.0}}) {
    INFO(below << " hundredths below the top");
    const double y = p.span - below * p.drift, x = input_at(p, rise, y);
    const ComposedCurve back = reversed(p, rise, y);
    const ElamCurve plain(model, false, x, y + model.y0(), x + converged * (60.0 - x));
    CHECK(back.xs == Approx(plain.split_x()).margin(1e-7));
    CHECK(back.ys == Approx(plain.split_y() - model.y0()).margin(1e-7));
    const ComposedCurve again = reversed(p, back, 0.5 * y);
    CHECK(again.ascending);
    CHECK(again.x_turn == Approx(input_at(p, back, 0.5 * y)));
    CHECK(again.y_turn == Approx(0.5 * y));
  }
  p.drift = 0.0;
  const double x = input_at(p, rise, p.span - 1e-3);
  CHECK(reversed(p, rise, p.span - 1e-3).xs ==
        Approx(ElamCurve(model, false, x, model.yu() - 1e-3).split_x()).margin(1e-7));
}

TEST_CASE("fast curves: the way back moves by its own slope on its side of the turn, and not at all without noise") {
  const ElamModel model = curve_models()[0];
  TaxelPattern p = pattern_like(model);
  const double y = 0.5 * p.span, s = p.step;
  const ComposedCurve rise = curve_from(p, true, 0.0, 0.0, 0.0), fall = reversed(p, rise, 0.8 * p.span);
  const double on_rise = input_at(p, rise, y), on_fall = input_at(p, fall, y);
  CHECK(reverse_sensitivity(p, rise, y, on_rise) ==
        Approx((on_rise - input_at(p, reversed(p, rise, y), y - s)) / s).epsilon(1e-9));
  CHECK(reverse_sensitivity(p, fall, y, on_fall) ==
        Approx((input_at(p, reversed(p, fall, y), y + s) - on_fall) / s).epsilon(1e-9));
  p.step = 0.0;
  CHECK(reverse_sensitivity(p, rise, y, on_rise) == 0.0);
  CHECK(sensitivity(p, rise, y, on_rise, 0) == 0.0);
}
