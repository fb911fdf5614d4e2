// POLY where its polynomial wavers, by hand: the places where it turns, and which input the inverse finds; and where a
// measured turn belongs to an external branch, of POLY and of ELAM.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/poly.h"

using namespace tactbench::analysis;

namespace {

// F(t) = 16 t^3 - 24 t^2 + 9 t: up to 1 at 1/4, down to 0 at 3/4, up to 1. With t = sin^2 a it is sin^2 3a.
double wave_at(double degrees) { return std::pow(std::sin(degrees / 180.0 * std::numbers::pi), 2); }

// From (10, 1) to (70, 5), of u = x - 10: `up` or down as F, the other way straight.
PolyModel waving_poly(bool up) {
  PolyParameters p;
  auto &wave = up ? p.a : p.b, &straight = up ? p.b : p.a;
  wave[3] = 16.0 / (60.0 * 60.0 * 60.0);
  wave[4] = -24.0 / (60.0 * 60.0);
  wave[5] = 9.0 / 60.0;
  straight[5] = 1.0 / 60.0;
  return {p, 10.0, 70.0, 1.0, 5.0};
}

}  // namespace

TEST_CASE("POLY by hand: a polynomial that wavers turns where its derivative is 0, rising and falling") {
  for (const bool up : {true, false}) {
    const PolyModel model = waving_poly(up);
    const std::vector<double> turns = model.extremes(up);
    REQUIRE(turns.size() == 2);
    CHECK(turns[0] == Approx(0.25));
    CHECK(turns[1] == Approx(0.75));
    CHECK(model.extremes(!up).empty());
  }
}

TEST_CASE("POLY by hand: the inverse of a wavering rise is the first input that gives the output") {
  const PolyModel model = waving_poly(true);
  const auto state = model.state();
  CHECK(state->output_at(25.0) == Approx(5.0));
  CHECK(state->output_at(55.0) == Approx(1.0).margin(1e-12));
  CHECK(state->output_at(40.0) == Approx(3.0));
  CHECK(state->input_at(3.0) == Approx(10.0 + 60.0 * wave_at(15.0)));
  CHECK(state->input_at(4.999) ==
        Approx(10.0 + 60.0 * wave_at(std::asin(std::sqrt(0.99975)) * 60.0 / std::numbers::pi)));
  // On from 30, which is beyond the first hill: up again after the fall to 55.
  state->go(30.0);
  const double here = 1.0 + 4.0 * (16.0 / 27.0 - 24.0 / 9.0 + 3.0);
  CHECK(state->output_at(30.0) == Approx(here));
  CHECK(state->input_at(4.9) ==
        Approx(10.0 + 60.0 * wave_at(60.0 + std::asin(std::sqrt(0.975)) * 60.0 / std::numbers::pi)));
  // A branch from 30 on the way down from 70: at (30, 1 + 4/3) it rises to 5 within a quarter of the 40 that are left.
  state->go(70.0);
  state->go(30.0);
  CHECK(state->output_at(30.0) == Approx(1.0 + 4.0 / 3.0));
  CHECK(state->output_at(40.0) == Approx(5.0));
  CHECK(state->output_at(60.0) == Approx(1.0 + 4.0 / 3.0));
  CHECK(state->input_at(1.0 + 4.0 / 3.0 + 8.0 / 3.0 * 0.5) == Approx(30.0 + 40.0 * wave_at(15.0)));
  CHECK(state->input_at(4.999) < 40.0);
}

TEST_CASE("POLY by hand: the inverse of a wavering fall is the first input that gives the output") {
  const PolyModel model = waving_poly(false);
  const auto state = model.state();
  state->go(70.0);
  CHECK(state->output_at(55.0) == Approx(1.0).margin(1e-12));
  CHECK(state->output_at(25.0) == Approx(5.0));
  CHECK(state->input_at(3.0) == Approx(10.0 + 60.0 * wave_at(75.0)));
  CHECK(state->input_at(1.001) > 55.0);
  // From a turn at 50, at 1 + 4 x 2/3: down to 1 at three quarters of the 40 to the low end, and up there again.
  const auto turned = model.state();
  turned->go(50.0);
  CHECK(turned->output_at(40.0) == Approx(1.0).margin(1e-12));
  CHECK(turned->output_at(20.0) == Approx(1.0 + 8.0 / 3.0));
  CHECK(turned->input_at(1.0 + 4.0 / 3.0) == Approx(10.0 + 40.0 * wave_at(75.0)));
}

TEST_CASE("POLY by hand: a turn measured within a hundredth of the ends is an external branch's") {
  PolyParameters p;
  p.a[5] = p.b[5] = 1.0 / 60.0;
  const PolyModel straight(p, 10.0, 70.0, 1.0, 5.0);
  for (const auto& [x, outer] :
       {std::pair{10.5, true}, {10.59, true}, {10.61, false}, {69.39, false}, {69.41, true}, {69.5, true}}) {
    CAPTURE(x);
    const auto state = straight.state();
    state->go(x);
    state->measured(3.0);
    CHECK(state->output_at(x) == (outer ? Approx(1.0 + (x - 10.0) / 15.0) : Approx(3.0)));
    // From a measured point each way is a branch of its own; from an external one it is straight on.
    CHECK(state->output_at(40.0) == (outer      ? Approx(3.0)
                                     : x > 40.0 ? Approx(1.0 + 2.0 * 30.0 / (x - 10.0))
                                                : Approx(3.0 + 2.0 * (40.0 - x) / (70.0 - x))));
  }
  CHECK_THROWS_AS(straight.state()->measured(std::nan("")), std::invalid_argument);
  const auto at_end = straight.state();
  at_end->go(10.25);
  at_end->measured(4.0);
  CHECK(at_end->output_at(10.25) == Approx(1.0 + 0.25 / 15.0));  // of the rise, not of a fall
  CHECK(at_end->output_at(12.0) == Approx(1.0 + 2.0 / 15.0));
}

TEST_CASE("POLY: parameters are taken that are finite, at ends in order") {
  PolyParameters p;
  p.a[5] = p.b[5] = 1.0;
  CHECK_NOTHROW(PolyModel(p, 0.0, 1.0, 0.0, 1.0));
  for (const auto& [x, y] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {-HUGE_VAL, 0.0}, {0.0, -HUGE_VAL}})
    CHECK_THROWS_AS(PolyModel(p, x, 1.0, y, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(PolyModel(p, 0.0, HUGE_VAL, 0.0, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(PolyModel(p, 0.0, 1.0, 0.0, HUGE_VAL), std::invalid_argument);
  p.a[6] = std::nan("");
  CHECK_THROWS_WITH(PolyModel(p, 0.0, 1.0, 0.0, 1.0), Catch::Contains("\"a\""));
  p.a[6] = 0.0;
  p.b[5] = 0.0;
  CHECK_THROWS_WITH(PolyModel(p, 0.0, 1.0, 0.0, 1.0), Catch::Contains("\"b\""));
}

TEST_CASE("ELAM by hand: a turn measured within a hundredth of the ends is an external branch's") {
  const std::vector<double> x{10.0, 40.0, 70.0}, y{1.0, 3.0, 5.0};
  const ElamHysteresis straight({PatternCurve(x, y, 1.0, 5.0), PatternCurve(x, y, 1.0, 5.0), {}, {}});
  for (const auto& [at, outer] :
       {std::pair{10.5, true}, {10.59, true}, {10.61, false}, {69.39, false}, {69.41, true}, {69.5, true}}) {
    CAPTURE(at);
    const auto state = straight.state();
    state->go(at);
    state->measured(3.0);
    CHECK(state->output_at(at) == (outer ? Approx(1.0 + (at - 10.0) / 15.0) : Approx(3.0)));
  }
  // A measured output is not below that of the unloaded film; above its highest it stays as it is.
  const auto state = straight.state();
  state->go(40.0);
  state->measured(0.5);
  CHECK(state->output_at(40.0) == 1.0);
  state->measured(5.5);
  CHECK(state->output_at(40.0) == 5.5);
  CHECK_THROWS_AS(state->measured(std::nan("")), std::invalid_argument);
}
