// Outputs, inverses and parameters of the models by hand, on loops with few numbers; the curves that they are made of.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/models/elam.h"
#include "analysis/models/gpi.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/pattern_curve.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/models.h"

using Knots = std::vector<double>;
using namespace synthetic;
using tactbench::analysis::PatternCurve;

namespace {

// Outputs along inputs, and back along these outputs.
void check_way(const HysteresisModel& model, const std::vector<std::pair<double, double>>& way) {
  const auto direct = model.state(), inverse = model.state();
  for (const auto& [x, y] : way) {
    CAPTURE(x, y);
    CHECK(direct->output_at(x) == Approx(y).margin(1e-12));
    const double back = inverse->input_at(y);
    CHECK(back == Approx(x).margin(1e-9));
    direct->go(x);
    inverse->go(back);
    CHECK(direct->output_at(x) == Approx(y).margin(1e-12));
  }
}

// Cells of two intervals: (0,0) 1, (1,0) 1, (1,1) 1. Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0.
PreisachModel small_preisach(double low = 0.0, double y_low = 0.0) { return {low, low + 60.0, y_low, {1, 1, 1}}; }

}  // namespace

TEST_CASE("Preisach: Everett's function over three cells matches hand-computed values") {
  const PreisachModel model = small_preisach();
  const std::vector<std::vector<double>> answers = {
      // high, low, rise: wholly in the first interval, over both, wholly in the second.
      {30, 0, 1},    {15, 0, 0.5},  {30, 15, 0.5}, {20, 10, 1.0 / 3.0}, {60, 0, 3}, {45, 0, 2}, {60, 30, 1},
      {60, 45, 0.5}, {45, 30, 0.5}, {60, 15, 2},   {45, 15, 1.0 + 0.0}, {0, 0, 0},  {10, 20, 0}};
  for (const std::vector<double>& own : answers) {
    CAPTURE(own[0], own[1]);
    CHECK(model.everett(own[0], own[1]) == Approx(own[2]).margin(1e-12));
    CHECK(small_preisach(-20.0, 5.0).everett(own[0] - 20.0, own[1] - 20.0) == Approx(own[2]).margin(1e-12));
  }
  CHECK(model.intervals() == 2);
}

TEST_CASE("Preisach: an inner loop closes, and a larger extreme wipes it out") {
  check_way(small_preisach(), {{15, 0.5}, {30, 1}, {45, 2}, {60, 3}, {45, 2.5}, {30, 2}, {15, 1}, {0, 0}, {30, 1}});
  // Down to 30 from 60: 2. Up to 45: 2.5, down again: 2, as before; on to 15: 1.
  check_way(small_preisach(), {{60, 3}, {30, 2}, {45, 2.5}, {30, 2}, {15, 1}, {30, 1.5}, {60, 3}, {30, 2}});
  // From 45: the rise of 2 comes back by 1 to 15, and goes on to 3.
  check_way(small_preisach(), {{45, 2}, {15, 1}, {45, 2}, {60, 3}});
  check_way(small_preisach(-20.0, 5.0), {{10, 6}, {40, 8}, {10, 7}, {-20, 5}});
}

TEST_CASE("monotone model: meets its knots, interpolates between them, and is constant beyond its ends") {
  const std::vector<double> x{0, 10, 30, 60}, y{0.0, 1.0, 3.0, 9.0};
  const MonotoneModel model(PatternCurve(x, y, 0.0, 9.0));
  check_way(model, {{0, 0}, {5, 0.5}, {10, 1}, {20, 2}, {30, 3}, {45, 6}, {60, 9}, {20, 2}});
  CHECK(model.state()->output_at(70.0) == 9.0);
  CHECK(model.state()->output_at(-1.0) == 0.0);
  CHECK(model.state()->input_at(9.5) == 60.0);
  CHECK(model.state()->input_at(-0.5) == 0.0);
  const PatternCurve curve(x, y, 0.0, 9.0);
  for (const auto& [at, slope] :
       {std::pair{-5.0, 0.1}, {0.0, 0.1}, {10.0, 0.1}, {25.0, 0.1}, {30.0, 0.2}, {59.0, 0.2}, {70.0, 0.2}})
    CHECK(curve.slope(at) == Approx(slope));
}

TEST_CASE("POLY: branches run from one turning point to the next and converge at the ends") {
  // Up and down straight: 0 to 60 is 0 to 3, whatever the branch.
  PolyParameters p;
  p.a[5] = p.b[5] = 0.05;
  const PolyModel straight(p, 0.0, 60.0, 0.0, 3.0);
  check_way(straight, {{20, 1}, {40, 2}, {10, 0.5}, {60, 3}, {0, 0}});
  // Up as the square of the share, down as twice the share less its square.
  PolyParameters q;
  q.a[4] = 1.0;
  q.b[4] = -1.0;
  q.b[5] = 120.0;
  const PolyModel bent(q, 0.0, 60.0, 0.0, 4.0);
  // 30: a quarter of 4. From there down to 15, half of the way: 3/4 of 1. Up to 37.5, half of the way to 60: a quarter
  // of what is missing to 4.
  check_way(bent, {{30, 1}, {15, 0.75}, {37.5, 0.75 + 0.25 * 3.25}, {60, 4}, {30, 3}, {45, 3.25}});
  const auto measured = bent.state();
  measured->go(30.0);
  measured->measured(2.0);
  CHECK(measured->output_at(45.0) == Approx(2.0 + 0.25 * 2.0));
  CHECK(measured->output_at(15.0) == Approx(0.75 * 2.0));
  CHECK(measured->input_at(2.5) == Approx(45.0));
  CHECK(measured->input_at(1.5) == Approx(15.0));
}

TEST_CASE("GPI: outputs of equal envelopes match hand-computed values, and thresholds widen the loop") {
  // With a1 = b1 = ln 2 / 10 the envelopes come half way nearer to 1 each 10: 1 - 2^(-x / 10), left and right alike.
  // The thresholds are 0 and four times 10, which no output reaches: the first operator is the envelope itself.
  const double halving = std::log(2.0) / 10.0;
  GpiParameters p{.a0 = 1,
                  .a1 = halving,
                  .a2 = 0,
                  .a3 = 1,
                  .b0 = 1,
                  .b1 = halving,
                  .b2 = 0,
                  .b3 = 1,
                  .alpha = 10,
                  .rho = 2,
                  .tau = 0};
  check_way(GpiModel(p, 0.0, 60.0, 0.5), {{10, 1.5}, {20, 2.0}, {30, 2.25}, {10, 1.5}, {0, 0.5}});
  // A threshold of a tenth: the second operator comes 0.1 later and stays 0.1 above on the way down; e^(-tau 0.1) =
  // 1/2, 1/4 and so on of the third to fifth.
  p.alpha = 0.1;
  p.tau = 10.0 * std::log(2.0);
  const GpiModel loop(p, 0.0, 60.0, 0.0);
  const auto up = [](double v) {
    return 2.0 * (v + 0.5 * std::max(0.0, v - 0.1) + 0.25 * std::max(0.0, v - 0.2) + 0.125 * std::max(0.0, v - 0.3) +
                  0.0625 * std::max(0.0, v - 0.4));
  };
  // At 10 the envelope is 0.5, at 20 0.75; back at 10 the operators stand at 0.5, 0.6, 0.55, 0.45, 0.35.
  check_way(
      loop,
      {{10, up(0.5)}, {20, up(0.75)}, {10, 2.0 * (0.5 + 0.5 * 0.6 + 0.25 * 0.55 + 0.125 * 0.45 + 0.0625 * 0.35)}});
  CHECK(loop.state()->output_at(5.0) == Approx(up(1.0 - std::sqrt(0.5))));
}

TEST_CASE("divider: converts output to linear output and back, up to its end and beyond") {
  // c = 1/4 a volt: u = v / (1 - v / 4), so that 2 V are 4 and 3 V 12, on a zero of half a volt.
  const Divider divider{0.5, 0.25};
  for (const auto& [output, linear] : {std::pair{0.5, 0.0}, {2.5, 4.0}, {3.5, 12.0}, {-0.5, -0.8}}) {
    CAPTURE(output);
    CHECK(divider.linear(output) == Approx(linear).margin(1e-12));
    CHECK(divider.output(linear) == Approx(output));
  }
  // The end is 0.995 of 4 V: 3.98 / 0.005 = 796; further volts count once.
  CHECK(divider.linear_end() == Approx(796.0));
  CHECK(divider.linear(4.48) == Approx(796.0));
  CHECK(divider.linear(4.68) == Approx(796.2));
  CHECK(divider.output(796.2) == Approx(4.68));
  CHECK(Divider{0.5, 0.0}.linear(2.5) == 2.0);
  CHECK(Divider{0.5, 0.0}.output(2.0) == 2.5);
  // A model behind it: 1 and 3 of the small loop are 1 / 1.25 and 3 / 1.75 above the zero.
  const LinearisedModel model(divider, std::make_shared<PreisachModel>(small_preisach()));
  check_way(model, {{30, 0.5 + 0.8}, {60, 0.5 + 3.0 / 1.75}, {30, 0.5 + 2.0 / 1.5}, {0, 0.5}});
}

// Lists of the models' parameters, whole: names, values, units, bounds, and which are held by convention. And when a
// parameter counts as lying at its bound.

namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

std::string listed(const HysteresisModel& model) {
  std::string lines;
  for (const ModelParameter& p : model.parameters())
    lines += fmt::format("{} {:g} {} [{:g}, {:g}]{}\n", p.name, p.value, p.unit, p.low, p.high, p.fixed ? " held" : "");
  return lines;
}

PatternCurve bent_line(double middle) {
  const std::vector<double> x{10.0, 30.0, 60.0}, y{0.0, middle, 3.0};
  return {x, y, 0.0, 3.0};
}

}  // namespace

TEST_CASE("models: list their parameters with units and bounds") {
  const ElamModel elam{bent_line(1.0), bent_line(2.0), {0.1, 0.2, 0.015, 0.3, 0.4}, {}};
  CHECK(listed(ElamHysteresis(elam, false)) ==
        "alpha_d 0.1 1 [0, 1]\nbeta_d 0.2 1 [0, 1]\nalpha_a1 0.015 1/x [-0.02, 0.02]\nalpha_a0 0.3 1 [0, 1]\n"
        "beta_a 0.4 1 [0, 1]\n");
  CHECK(kMaxPieceLog == 2.0);
  CHECK(listed(ElamHysteresis(elam, true, {{0.5}, {-0.5, 0.25}, {1.0, -1.0}, {2.0}})) ==
        "alpha_d 0.1 1 [0, 1]\nbeta_d 0.2 1 [0, 1]\nalpha_a1 0.015 1/x [-0.02, 0.02]\nalpha_a0 0.3 1 [0, 1]\n"
        "beta_a 0.4 1 [0, 1]\nlog_d1 0.5 1 [-2, 2]\nlog_d2 -0.5 1 [-2, 2]\nlog_d3 0.25 1 [-2, 2]\n"
        "log_a1 1 1 [-2, 2]\nlog_a2 -1 1 [-2, 2]\nlog_a3 2 1 [-2, 2]\n");
  CHECK(listed(GpiModel({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 0.0, 60.0, 0.0)) ==
        "a0 1 y [0, inf]\na1 2 1/x [0, inf]\na2 3 1 [-inf, inf] held\na3 4 y [-inf, inf]\n"
        "b0 5 y [0, inf]\nb1 6 1/x [0, inf]\nb2 7 1 [-inf, inf] held\nb3 8 y [-inf, inf]\n"
        "alpha 9 y [0, inf]\nrho 10 1 [0, inf] held\ntau 11 1/y [-inf, inf]\n");
  CHECK(listed(MpiModel({0.1, 0.2, 0.3, 4, -0.5}, 0.0, 60.0, 0.0)) ==
        "a1 0.1 y/x [-inf, inf]\na2 0.2 y/x^2 [-inf, inf]\na3 0.3 y/x^3 [-inf, inf]\nrho 4 y [0, inf]\n"
        "tau -0.5 1 [-5, 5]\n");
  const PolyParameters poly{{1, 2, 3, 4, 5, 6, 7}, {8, 9, 10, 11, 12, 13, 14}};
  CHECK(listed(PolyModel(poly, 0.0, 1.0, 0.0, 3.0)) ==
        "a0 1 y/x^6 [-inf, inf]\na1 2 y/x^5 [-inf, inf]\na2 3 y/x^4 [-inf, inf]\na3 4 y/x^3 [-inf, inf]\n"
        "a4 5 y/x^2 [-inf, inf]\na5 6 y/x [-inf, inf]\na6 7 y [-inf, inf]\n"
        "b0 8 y/x^6 [-inf, inf]\nb1 9 y/x^5 [-inf, inf]\nb2 10 y/x^4 [-inf, inf]\nb3 11 y/x^3 [-inf, inf]\n"
        "b4 12 y/x^2 [-inf, inf]\nb5 13 y/x [-inf, inf]\nb6 14 y [-inf, inf]\n");
  // Weights that are 0 are none.
  const auto film = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 0, 2, 3, 0, 4});
  const std::string weights = "w(0,0) 1 y [0, inf]\nw(1,1) 2 y [0, inf]\nw(2,0) 3 y [0, inf]\nw(2,2) 4 y [0, inf]\n";
  CHECK(listed(*film) == weights);
  CHECK(listed(LinearisedModel({0.5, 0.1}, film)) == "c 0.1 1/y [0, inf]\n" + weights);
  CHECK(listed(LinearisedModel({0.5, 0.0}, film)) == "c 0 1/y [-inf, inf]\n" + weights);
  CHECK(listed(MonotoneModel(bent_line(1.0))) == "y0 0 y [-inf, inf]\ny1 1 y [-inf, inf]\ny2 3 y [-inf, inf]\n");
}

TEST_CASE("models: state their operations per sample, which increase with ELAM's pieces") {
  const ElamModel elam{bent_line(1.0), bent_line(2.0), {}, {}};
  CHECK(ElamHysteresis(elam, false).operations_per_sample() == 9);
  CHECK(ElamHysteresis(elam, false, {{0.1}, {}, {}, {0.1}}).operations_per_sample() == 13);
  CHECK(ElamHysteresis(elam, false, {{0.1}, {0.1}, {0.1}, {0.1}}).operations_per_sample() == 14);
  CHECK(GpiModel({}, 0.0, 60.0, 0.0).operations_per_sample() == 39);
  CHECK(MpiModel({}, 0.0, 60.0, 0.0).operations_per_sample() == 56);
  CHECK(PreisachModel(0.0, 60.0, 0.0, {1.0}).operations_per_sample() == 16);
  CHECK(PolyModel({{0, 0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1, 0}}, 0.0, 1.0, 0.0, 3.0).operations_per_sample() == 18);
  CHECK(MonotoneModel(bent_line(1.0)).operations_per_sample() == 3);
  const auto film = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1.0});
  CHECK(LinearisedModel({}, film).operations_per_sample() == 18);
}

TEST_CASE("model parameter: is at its bound within 1e-9 of the distance between both bounds, or of 1 if open") {
  using Row = std::tuple<double, double, double, bool>;  // value, bounds
  const Row rows[] = {{2.0, 2.0, 6.0, true},
                      {2.0 + 3.9e-9, 2.0, 6.0, true},
                      {2.0 + 4.1e-9, 2.0, 6.0, false},
                      {6.0 - 3.9e-9, 2.0, 6.0, true},
                      {6.0 - 4.1e-9, 2.0, 6.0, false},
                      {4.0, 2.0, 6.0, false},
                      {0.99e-9, 0.0, kNoBound, true},
                      {1.01e-9, 0.0, kNoBound, false},
                      {-0.99e-9, -kNoBound, 0.0, true},
                      {-1.01e-9, -kNoBound, 0.0, false},
                      {0.0, -kNoBound, kNoBound, false}};
  for (const auto& [value, low, high, at_bound] : rows) {
    CAPTURE(value, low, high);
    CHECK(ModelParameter{"p", value, "1", low, high}.at_bound() == at_bound);
  }
}

namespace {

void check_strictly_rising(const PatternCurve& curve) {
  for (std::size_t i = 1; i < curve.y().size(); ++i) REQUIRE(curve.y()[i] > curve.y()[i - 1]);
}

}  // namespace

TEST_CASE("PatternCurve: a rising curve is kept bit for bit and interpolated linearly") {
  const Knots x{0, 2, 4, 10}, y{0.1, 0.3, 0.9, 1.7};
  const PatternCurve curve(x, y, 0.1, 1.7);
  CHECK(Knots(curve.y().begin(), curve.y().end()) == y);
  CHECK(curve(3.0) == Approx(0.6));
  CHECK(curve(-1.0) == 0.1);
  CHECK(curve(11.0) == 1.7);
  CHECK(curve.inverse(0.6) == Approx(3.0));
  CHECK(curve.inverse(0.0) == 0.0);
  CHECK(curve.inverse(2.0) == 10.0);
  CHECK(curve.slope(3.0) == Approx(0.3));
  CHECK(curve.slope(2.0) == Approx(0.3));
  CHECK(curve.slope(99.0) == Approx(0.8 / 6.0));
}

TEST_CASE("PatternCurve: falling outputs are replaced by their mean, between fixed ends") {
  for (const auto& [y, low, high, pooled] :
       {std::tuple{Knots{0, 3, 1, 2, 5}, 0.0, 5.0, Knots{0, 2, 2, 2, 5}},
        // 4 | 5 3 -> 4 | 4 4; then 2.5 pulls all three down: mean of 4, 5, 3, 2.5.
        {Knots{0, 4, 5, 3, 2.5, 9}, 0.0, 9.0, Knots{0, 3.625, 3.625, 3.625, 3.625, 9}},
        {Knots{9, -1, 7, 9}, 0.0, 5.0, Knots{0, 0, 5, 5}},
        // At the first or at the last step alone.
        {Knots{1, 0.5, 2, 3}, 1.0, 3.0, Knots{1, 1, 2, 3}},
        {Knots{1, 2, 3.5, 3}, 1.0, 3.0, Knots{1, 2, 3, 3}}}) {
    Knots x;
    while (x.size() < y.size()) x.push_back(static_cast<double>(x.size()));
    const PatternCurve curve(x, y, low, high);
    CAPTURE(y);
    check_strictly_rising(curve);
    CHECK(curve.y().front() == low);
    CHECK(curve.y().back() == high);
    for (std::size_t i = 0; i < x.size(); ++i) CHECK(curve.y()[i] == Approx(pooled[i]).margin(1e-7));
  }
}

TEST_CASE("PatternCurve: a saturated curve keeps the minimum slope and can be inverted") {
  const PatternCurve curve(Knots{0, 20, 40, 60}, Knots{0, 3.5, 3.5, 3.5}, 0, 3.5);
  check_strictly_rising(curve);
  CHECK((curve.y()[3] - curve.y()[2]) / 20.0 == Approx(1e-9 * 3.5 / 60.0).epsilon(1e-3));
  const double middle = 0.5 * (curve.y()[2] + curve.y()[3]);
  CHECK(curve.inverse(middle) == Approx(50.0).margin(1e-3));
}

TEST_CASE("PatternCurve: a curve that is already monotone is not changed") {
  const PatternCurve once(Knots{0, 1, 2, 3, 4, 5}, Knots{0, 3, 1, 2, 5, 4.9}, 0, 5);
  const PatternCurve twice(once.x(), once.y(), once.y().front(), once.y().back());
  CHECK(Knots(once.y().begin(), once.y().end()) == Knots(twice.y().begin(), twice.y().end()));
}

TEST_CASE("PatternCurve: a step of half the minimum slope is kept, a smaller one is raised to the minimum") {
  // Over 2 and 2: the minimum is 1e-9.
  CHECK(PatternCurve(Knots{0, 1, 2}, Knots{0, 0.5 * 1e-9, 2}, 0, 2).y()[1] == 0.5 * 1e-9);
  CHECK(PatternCurve(Knots{0, 1, 2}, Knots{0, 0.49 * 1e-9, 2}, 0, 2).y()[1] == Approx(1e-9));
}

TEST_CASE("PatternCurve: grids need not be uniform") {
  const Knots x{0, 0.1, 0.2, 50, 59, 60}, y{0, 1, 2, 3, 4, 5};
  const PatternCurve curve(x, y, 0, 5);
  for (std::size_t i = 0; i < x.size(); ++i) CHECK(curve(x[i]) == Approx(y[i]));
  for (double v = 0.05; v < 5.0; v += 0.1) CHECK(curve(curve.inverse(v)) == Approx(v).epsilon(1e-12));
}

TEST_CASE("PatternCurve: invalid curves, and knots too close for the minimum slope, are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  using Row = std::tuple<Knots, Knots, double, double>;  // x, y, the ends' outputs
  const Row rows[] = {{{0}, {0}, 0, 1},
                      {{0, 1}, {0}, 0, 1},
                      {{0, 0}, {0, 1}, 0, 1},
                      {{0, nan}, {0, 1}, 0, 1},
                      {{0, 1}, {0, inf}, 0, 1},
                      {{0, 1}, {0, 1}, 0, nan},
                      {{0, 1}, {0, 1}, 1, 1},
                      {{0, 1}, {1, 0}, 1, 0},
                      {{0, 1e-12, 2}, {1, 0.5, 3}, 1, 3},
                      {{0, 2 - 1e-12, 2}, {1, 3.5, 3}, 1, 3}};
  for (const auto& [x, y, low, high] : rows) {
    CAPTURE(x, y, low, high);
    CHECK_THROWS_AS(PatternCurve(x, y, low, high), std::invalid_argument);
  }
}

// MPI's way from one end to the other by hand: where its output may turn, and which input the inverse finds.

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
