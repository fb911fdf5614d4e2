// ELAM's further pieces and its memory by hand, on a straight loop: 60 psi are 3 V.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/models/elam_hysteresis.h"

using namespace tactbench::analysis;

namespace {

// From (10, 1) to (70, 4), splits halfway.
ElamModel straight_elam(bool exact_outer = false) {
  const std::vector<double> x{10, 70}, y{1, 4};
  return {PatternCurve(x, y, 1.0, 4.0), PatternCurve(x, y, 1.0, 4.0), {}, {exact_outer}};
}

void check_curve(const ElamPiecedCurve& curve, const std::vector<std::pair<double, double>>& places) {
  for (const auto& [x, y] : places) {
    CAPTURE(x, y);
    CHECK(curve.output(x) == Approx(y));
    CHECK(curve.input(y) == Approx(x));
  }
}

}  // namespace

TEST_CASE("ELAM by hand: descending, pieces evenly in x rise by their weights, within their side") {
  const ElamModel model = straight_elam();
  // Below the split at (40, 2.5) two pieces of 15 psi and 0.75 V; the second has twice the weight: 0.5 and 1 V.
  const ElamPieces low{{std::log(2.0)}, {}, {}, {std::log(3.0)}};
  check_curve({model, low, false, 70.0, 4.0},
              {{70, 4}, {55, 3.25}, {40, 2.5}, {32.5, 2.0}, {25, 1.5}, {17.5, 1.25}, {10, 1}});
  // Above it three: of weights 1, 2 and 1 they rise by 3/8, 6/8 and 3/8 of a volt.
  const ElamPieces high{{}, {std::log(2.0), 0.0}, {0.0, 0.0}, {}};
  check_curve({model, high, false, 70.0, 4.0}, {{70, 4}, {60, 3.625}, {55, 3.25}, {50, 2.875}, {40, 2.5}, {25, 1.75}});
  // From (50, 3): the split at (30, 2), below it 0.5 V each, and 1/3 and 2/3 by weight.
  check_curve({model, low, false, 50.0, 3.0},
              {{50, 3}, {40, 2.5}, {30, 2}, {20, 1.0 + 1.0 / 3.0}, {15, 1.0 + 1.0 / 6.0}});
}

TEST_CASE("ELAM by hand: ascending, pieces evenly in y are as long as their weights, within their side") {
  const ElamModel model = straight_elam();
  // Above the split at (40, 2.5) two pieces of 15 psi; of weights 1 and 3 they are 7.5 and 22.5 psi long.
  const ElamPieces high{{std::log(2.0)}, {}, {}, {std::log(3.0)}};
  check_curve({model, high, true, 10.0, 1.0},
              {{10, 1}, {25, 1.75}, {40, 2.5}, {43.75, 2.875}, {47.5, 3.25}, {58.75, 3.625}, {70, 4}});
  // Below it: weights 1 and 1/2.
  const ElamPieces low{{std::log(2.0)}, {}, {std::log(0.5)}, {}};
  check_curve({model, low, true, 10.0, 1.0}, {{10, 1}, {20, 1.375}, {30, 1.75}, {35, 2.125}, {40, 2.5}, {55, 3.25}});
  // From (30, 2): the split at (50, 3); above it 5 and 15 psi.
  check_curve({model, high, true, 30.0, 2.0}, {{30, 2}, {40, 2.5}, {50, 3}, {55, 3.5}, {62.5, 3.75}, {70, 4}});
  CHECK(high.splits() == 2);
  CHECK(ElamPieces{{0, 0}, {0}, {}, {}}.splits() == 4);
}

TEST_CASE("ELAM by hand: a branch that begins at exactly a hundredth of the range from its end is external") {
  // One volt a psi over 64 psi; the lower pieces differ in size.
  const auto from = [](double low) {
    const std::vector<double> x{low, low + 64.0}, y{0.0, 64.0};
    return ElamModel{PatternCurve(x, y, 0.0, 64.0), PatternCurve(x, y, 0.0, 64.0), {}, {true}};
  };
  const ElamPieces low{{std::log(2.0)}, {}, {std::log(0.5)}, {}};
  const double near = kOuterShare * 64.0;
  const ElamModel falls = from(-64.0), rises = from(0.0);
  // The whole curve, its ordinates scaled to the turn.
  CHECK(ElamPiecedCurve(falls, low, false, -near, 64.0 - near).output(-48.0) == Approx(0.99 * 16.0));
  CHECK(ElamPiecedCurve(falls, low, false, -near - 1e-9, 64.0 - near).output(-48.0) < 15.0);
  CHECK(ElamPiecedCurve(rises, low, true, near, near).output(16.0) == Approx(16.0));
  CHECK(ElamPiecedCurve(rises, low, true, near + 1e-9, near).output(16.0) < 15.5);
}

TEST_CASE(
    "ELAM by hand: with memory a branch closes its loop, its ordinates scaled, and goes on along the one before") {
  const ElamHysteresis model(straight_elam(), true);
  const auto state = model.state();
  state->go(50.0);
  state->go(30.0);
  CHECK(state->output_at(30.0) == Approx(2.0));
  // Measured 0.2 V higher: from there to (50, 3), half of the way a half of the rise; beyond it the rise before.
  state->measured(2.2);
  CHECK(state->output_at(30.0) == 2.2);
  CHECK(state->output_at(40.0) == Approx(2.6));
  CHECK(state->output_at(50.0) == Approx(3.0));
  CHECK(state->output_at(60.0) == Approx(3.5));
  CHECK(state->input_at(2.6) == Approx(40.0));
  CHECK(state->input_at(3.5) == Approx(60.0));
  // Down from there it is a way to the low end.
  CHECK(state->output_at(20.0) == Approx(1.0 + 1.2 / 2.0));
  CHECK(state->input_at(1.6) == Approx(20.0));
  state->go(40.0);
  state->go(35.0);
  CHECK(state->output_at(35.0) == Approx(2.4));
  // Two loops inside: up to 40 and on to 50, down again.
  CHECK(state->output_at(45.0) == Approx(2.8));
  CHECK(state->input_at(2.8) == Approx(45.0));
  state->go(60.0);
  CHECK(state->output_at(60.0) == Approx(3.5));
  CHECK(state->output_at(40.0) == Approx(2.5));
  CHECK(state->output_at(10.0) == 1.0);
  // What is measured stays within the loop that is open: from (60, 3.5) down to (10, 1).
  state->go(40.0);
  state->measured(3.9);
  CHECK(state->output_at(40.0) == Approx(3.5));
  state->measured(0.5);
  CHECK(state->output_at(40.0) == Approx(1.0));
  CHECK(state->output_at(70.0) == 4.0);
  state->reset();
  CHECK(state->output_at(40.0) == Approx(2.5));
}
