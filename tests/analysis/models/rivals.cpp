// MPI's way from one end to the other by hand: where its output may turn, and which input the inverse finds.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "analysis/models/elam.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "tests/analysis/support/alike.h"

using namespace tactbench::analysis;

namespace {

// The input is u itself, 0 to 1. With tau = 0 and rho = 10 each operator counts 1: going up from rest the slope of
// their sum is 1 below 0.1, 2 up to 0.2, and so on to 10; coming down from 1 it is 1 above 0.9, 2 down to 0.8, and so
// on.
MpiModel even_mpi(double a1, double a2, double a3) { return {{a1, a2, a3, 10.0, 0.0}, 0.0, 1.0, 0.0}; }

// The output going up from rest to u: the cubic and each operator's way beyond its threshold.
double up_by_hand(double a1, double a2, double a3, double u) {
  double y = a1 * u + a2 * u * u + a3 * u * u * u;
  for (int i = 0; i < 10; ++i) y += std::max(0.0, u - i / 10.0);
  return y;
}

}  // namespace

TEST_CASE("MPI: each threshold starts a monotone piece, rising and falling, from rest and in between") {
  const MpiModel model = even_mpi(1.0, 0.0, 0.0);
  const MpiModel::Operators rest{};
  check_alike(model.monotone_pieces(rest, 0.0, 1.0), {0, .1, .2, .3, .4, .5, .6, .7, .8, .9, 1}, 1e-12);
  const MpiModel::Operators top = MpiModel::moved(rest, 1.0);
  check_alike(model.monotone_pieces(top, 1.0, 0.0), {1, .9, .8, .7, .6, .5, .4, .3, .2, .1, 0}, 1e-12);
  // Down to 0.45: the operators above stand there, those below where the top left them; each rises from there by its
  // threshold. Of 0.45, 0.45, 0.45, 0.45, 0.45, 0.45, 0.4, 0.3, 0.2, 0.1 and 0 to 0.9 that is 0.55 to 0.95 and 1 four
  // times.
  const MpiModel::Operators between = MpiModel::moved(top, 0.45);
  check_alike(model.monotone_pieces(between, 0.45, 1.0), {.45, .55, .65, .75, .85, .95, 1}, 1e-12);
  check_alike(model.monotone_pieces(between, 0.45, 0.0), {.45, .4, .3, .2, .1, 0}, 1e-12);
}

TEST_CASE("MPI: a monotone piece ends where the cubic falls as fast as the operators rise") {
  const MpiModel::Operators rest{}, top = MpiModel::moved(rest, 1.0);
  // Between 0.4 and 0.5 the operators' slope is 5, with a1 = 1 it is 6: as much as 3 a u^2 at u = 0.45 when a = 2 /
  // 0.45^2. Nowhere else: sqrt((k + 2) / 3a) lies in no other (k / 10, (k + 1) / 10).
  check_alike(even_mpi(1.0, 0.0, -2.0 / (0.45 * 0.45)).monotone_pieces(rest, 0.0, 1.0),
              {0, .1, .2, .3, .4, .45, .5, .6, .7, .8, .9, 1}, 1e-12);
  // Coming down the slope is 6 between 0.6 and 0.5.
  check_alike(even_mpi(1.0, 0.0, -2.0 / (0.55 * 0.55)).monotone_pieces(top, 1.0, 0.0),
              {1, .9, .8, .7, .6, .55, .5, .4, .3, .2, .1, 0}, 1e-12);
  // Two turns in one piece: 3 a (u - 0.42) (u - 0.48) = 3 a u^2 - 2.7 a u + 6 with a = 2 / (0.42 x 0.48). With slopes
  // of 3 and 2 the roots are (0.9 -+ sqrt(0.81 - 0.4032)) / 2 and (0.9 -+ sqrt(0.81 - 0.2688)) / 2, the lower ones of
  // which lie in their pieces.
  const double a = 2.0 / (0.42 * 0.48);
  check_alike(even_mpi(1.0, -1.35 * a, a).monotone_pieces(rest, 0.0, 1.0),
              {0, (0.9 - std::sqrt(0.5412)) / 2, .1, (0.9 - std::sqrt(0.4068)) / 2, .2, .3, .4, .42, .48, .5, .6, .7,
               .8, .9, 1},
              1e-12);
}

TEST_CASE("MPI: the inverse is the first input that gives the output, before and after a fall") {
  const double a = 2.0 / (0.42 * 0.48);
  const MpiModel model = even_mpi(1.0, -1.35 * a, a);
  // A fine walk over the formula: the first place at which the output has come to y.
  const auto first_place = [&](double y) {
    for (int k = 0; k <= 100'000; ++k)
      if (up_by_hand(1.0, -1.35 * a, a, k / 100'000.0) >= y) return k / 100'000.0;
    return 1.0;
  };
  const double end = up_by_hand(1.0, -1.35 * a, a, 1.0), hill = up_by_hand(1.0, -1.35 * a, a, 0.0822);
  for (const double y : {0.02, 0.999 * hill, 1.001 * hill, 0.2, 0.5, 0.3 * end, 0.7 * end, 0.99 * end}) {
    CAPTURE(y);
    const auto state = model.state();
    const double x = state->input_at(y);
    CHECK(x == Approx(first_place(y)).margin(2e-5));
    CHECK(state->output_at(x) == Approx(y));
  }
  CHECK(model.state()->input_at(end + 1.0) == 1.0);
  CHECK(model.state()->input_at(-1.0) == 0.0);
}

TEST_CASE("MPI: densities and outputs of a range with offsets match hand-computed values") {
  // e^(-tau (i - 1)^2) / 10 at i = 0, 1, 2, 3 with tau = ln 2: a half, 1, a half, a sixteenth of a tenth.
  const MpiModel::Operators densities = MpiModel::densities(std::log(2.0));
  CHECK(densities[0] == Approx(0.05));
  CHECK(densities[1] == Approx(0.1));
  CHECK(densities[2] == Approx(0.05));
  CHECK(densities[3] == Approx(0.1 / 16.0));
  // From 5 to 25: at 15 u is a half. 0.7 + 0.1 x 10 + 0.02 x 100 + 0.003 x 1000, and 0.5 + 0.4 + 0.3 + 0.2 + 0.1 of
  // operators.
  const MpiModel model({0.1, 0.02, 0.003, 10.0, 0.0}, 5.0, 25.0, 0.7);
  const auto state = model.state();
  CHECK(state->output_at(15.0) == Approx(0.7 + 1.0 + 2.0 + 3.0 + 1.5));
  CHECK(state->input_at(8.2) == Approx(15.0));
  state->go(25.0);
  // Coming down to 15: the operators stand at 0.5 six times, then 0.4, 0.3, 0.2 and 0.1.
  CHECK(state->output_at(15.0) == Approx(0.7 + 6.0 + 4.0));
  CHECK(state->input_at(10.7) == Approx(15.0));
  CHECK(model.operations_per_sample() == 2 + 9 * 5 + 2 + 6 + 1);
}

// POLY where its polynomial wavers, by hand: the places where it turns, and which input the inverse finds; and where a
// measured turn belongs to an external branch, of POLY and of ELAM.

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

TEST_CASE("POLY: a non-monotone polynomial has extremes where its derivative is 0, rising and falling") {
  for (const bool up : {true, false}) {
    const PolyModel model = waving_poly(up);
    const std::vector<double> turns = model.extremes(up);
    REQUIRE(turns.size() == 2);
    CHECK(turns[0] == Approx(0.25));
    CHECK(turns[1] == Approx(0.75));
    CHECK(model.extremes(!up).empty());
  }
}

TEST_CASE("POLY: the inverse of a non-monotone rise is the first input that gives the output") {
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

TEST_CASE("POLY: the inverse of a non-monotone fall is the first input that gives the output") {
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

TEST_CASE("POLY: a turning point measured within 1 % of an end starts an external branch") {
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

TEST_CASE("POLY: parameters must be finite, and the ends in order") {
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

TEST_CASE("ELAM: a turning point measured within 1 % of an end starts an external branch") {
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
