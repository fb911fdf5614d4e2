// ELAM's curves at their turns, splits, ends and knots and beside each of them, to the last bit, as they were when
// recorded; and where parts of them have no length, by hand.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/models/elam_pieces.h"
#include "tests/analysis/compensate/recorded_streams.h"
#include "tests/analysis/support/bits.h"

using namespace tactbench::analysis;
using recorded::Numbers;
using to_the_bit::Bits;

namespace {

enum class Shape { kBent, kFlatTop, kFlatFoot };

struct DrawnElam {
  Numbers& number;
  bool round;    // all in eighths
  double shift;  // the range is 64 long from here
  Shape shape;

  double share() { return round ? std::floor(9.0 * number()) / 8.0 : number(); }
  ElamModel model(bool exact_outer) {
    std::vector<double> x{0.0, 8.0, 20.0, 32.0, 44.0, 56.0, 64.0};
    for (double& at : x) at += shift;
    std::vector<double> up{0.5, 0.625, 1.0, 1.5, 2.125, 2.75, 3.5}, down{0.5, 1.5, 2.5, 3.0, 3.25, 3.375, 3.5};
    if (shape == Shape::kFlatTop) down = {0.5, 2.0, 3.5, 3.5, 3.5, 3.5, 3.5}, up = {0.5, 1.0, 2.0, 3.0, 3.5, 3.5, 3.5};
    if (shape == Shape::kFlatFoot) up = {0.5, 0.5, 0.5, 0.5, 1.0, 2.0, 3.5}, down = {0.5, 0.5, 0.5, 1.0, 2.0, 3.0, 3.5};
    const double u = share(), v = share();
    const double alpha_d = share(), beta_d = share(), beta_a = share();
    return {PatternCurve(x, up, 0.5, 3.5),
            PatternCurve(x, down, 0.5, 3.5),
            {alpha_d, beta_d, (v - u) / 64.0, u, beta_a},
            {exact_outer}};
  }
  // Within the range, at its ends, at a hundredth from them, or beyond.
  double turn() {
    const double kind = number(), near = kOuterShare * 64.0;
    const std::array<double, 6> special{shift,       shift + 64.0,        shift + near,
                                        shift - 2.0, shift + 64.0 - near, shift + 70.0};
    if (kind < 0.3) return special[static_cast<std::size_t>(6.0 * number())];
    return shift + (round ? std::floor(257.0 * number()) / 4.0 : 64.0 * number());
  }
  double start() { return 0.25 + (round ? std::floor(33.0 * number()) / 8.0 : 4.0 * number()); }
};

// Outputs and inputs at the places and beside them.
template <class Curve>
void add_places(Bits& bits, const Curve& curve, const ElamModel& model, std::vector<double> x, std::vector<double> y) {
  for (const PatternCurve* pattern : {&model.ascending, &model.descending}) {
    x.insert(x.end(), pattern->x().begin(), pattern->x().end());
    y.insert(y.end(), pattern->y().begin(), pattern->y().end());
  }
  x.insert(x.end(), {model.x0() - 1.0, model.xu() + 1.0});
  y.insert(y.end(), {model.y0() - 1.0, model.yu() + 1.0});
  for (const double at : x)
    for (const double near : {to_the_bit::just_below(at), at, to_the_bit::just_above(at)}) bits.add(curve.output(near));
  for (const double at : y)
    for (const double near : {to_the_bit::just_below(at), at, to_the_bit::just_above(at)}) bits.add(curve.input(near));
}

std::string curves_drawn(Shape shape) {
  Bits bits;
  Numbers number(17);
  for (int trial = 0; trial < 240; ++trial) {
    DrawnElam drawn{number, trial % 2 == 0, trial % 3 == 0 ? 0.0 : trial % 3 == 1 ? -64.0 : 3.0, shape};
    const ElamModel model = drawn.model(trial % 4 < 2);
    for (const bool up : {true, false}) {
      const double x = drawn.turn(), y = drawn.start();
      const ElamCurve curve(model, up, x, y);
      for (const double own : {curve.turn_x(), curve.turn_y(), curve.split_x(), curve.split_y()}) bits.add(own);
      add_places(bits, curve, model, {curve.turn_x(), curve.split_x()}, {curve.turn_y(), curve.split_y()});
      const ElamCurve late(model, up, x, y, x + (trial % 5 == 0 ? 4.0 : 80.0 * number() - 10.0));
      add_places(bits, late, model, {late.turn_x(), late.split_x()}, {late.turn_y(), late.split_y()});
      // Pieces of one size, one to three a side.
      const ElamPieces even{{0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0}};
      const ElamPiecedCurve pieced(model, even, up, x, y);
      add_places(bits, pieced, model, {curve.turn_x(), curve.split_x()}, {curve.turn_y(), curve.split_y()});
    }
  }
  return bits.text();
}

// A line from 0 to 1 V over one psi far from 0, where inputs next to each other lie 1e-10 apart.
ElamModel far_line(double alpha_d, double beta_d, double beta_a) {
  const std::vector<double> x{1e6, 1e6 + 1.0}, y{0.0, 1.0};
  return {PatternCurve(x, y, 0.0, 1.0), PatternCurve(x, y, 0.0, 1.0), {alpha_d, beta_d, 0.0, 0.5, beta_a}, {}};
}

}  // namespace

TEST_CASE("recorded: ELAM's curves at all their places and beside them are the same to the last bit") {
  CHECK(curves_drawn(Shape::kBent) == "de9f55cdd51ca61b");
  CHECK(curves_drawn(Shape::kFlatTop) == "a9529b6c83549349");
  CHECK(curves_drawn(Shape::kFlatFoot) == "e3301600c4ee4369");
}

TEST_CASE("ELAM: a split so near to a rise's end or begin that the pattern has no input between them") {
  // From the lowest input: split at 1e6 + 0.5 and at all but a billionth of the rise.
  const ElamModel late = far_line(0.5, 0.5, 1.0 - 1e-12);
  CHECK(ElamCurve(late, true, 1e6, 0.0).split_x() == 1e6 + 0.5);
  CHECK(ElamCurve(late, true, 1e6, 0.0).input(1.0 - 0.5e-12) == 1e6 + 1.0);
  CHECK(ElamCurve(late, true, 1e6, 0.0).input(0.5) == Approx(1e6 + 0.25).epsilon(1e-15));
  const ElamModel early = far_line(0.5, 0.5, 1e-12);
  CHECK(ElamCurve(early, true, 1e6, 0.0).input(0.5e-12) == 1e6 + 0.5);
  CHECK(ElamCurve(early, true, 1e6, 0.0).input(0.5) == Approx(1e6 + 0.75).epsilon(1e-15));
}

TEST_CASE("ELAM: curves meet their split points exactly") {
  Numbers number(23);
  for (int trial = 0; trial < 300; ++trial) {
    DrawnElam drawn{number, false, 3.0, Shape::kBent};
    const ElamModel model = drawn.model(false);
    const double x = 4.0 + 62.0 * number();
    const double y = model.ascending(x) + (model.descending(x) - model.ascending(x)) * number();
    const ElamCurve down(model, false, x, y);
    CAPTURE(trial, x, y);
    CHECK(down.output(down.split_x()) == down.split_y());
    CHECK(down.input(down.split_y()) >= down.split_x());
    CHECK(down.input(down.split_y()) == Approx(down.split_x()).epsilon(1e-12));
  }
}
