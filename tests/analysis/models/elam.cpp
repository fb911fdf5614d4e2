#include "analysis/models/elam.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

ElamParameters any_parameters(Random& random, double margin) {
  const double u = random(margin, 1.0 - margin), v = random(margin, 1.0 - margin);
  return {random(margin, 1.0 - margin), random(margin, 1.0 - margin), (v - u) / 62.0, u, random(margin, 1.0 - margin)};
}

// A loop with any rises; now and then a saturated top. Offsets differ from zero: the general form [A4].
Loop any_loop(Random& random, bool saturated) {
  Loop loop;
  double up = 0.2, down = 0.2;
  for (int i = 0; i <= 30; ++i) {
    loop.x.push_back(5.0 + 2.0 * i);
    loop.up.push_back(up);
    loop.down.push_back(down);
    up += random(0.02, 0.2);
    down += saturated && i > 15 ? 0.0 : random(0.05, 0.3);
  }
  for (double& y : loop.down) y = 0.2 + (y - 0.2) * (up - 0.2) / (down - 0.2);
  loop.up.push_back(up);
  loop.down.push_back(up);
  loop.x.push_back(67.0);
  return loop;
}

// A line from 0 to 1 V over one psi far from 0, where inputs next to each other lie 1e-10 apart.
ElamModel far_line(double alpha_d, double beta_d, double beta_a) {
  const std::vector<double> x{1e6, 1e6 + 1.0}, y{0.0, 1.0};
  return {PatternCurve(x, y, 0.0, 1.0), PatternCurve(x, y, 0.0, 1.0), {alpha_d, beta_d, 0.0, 0.5, beta_a}, {}};
}

}  // namespace

TEST_CASE("direct and inverse undo each other along 1000 random histories with interrupted branches") {
  Random random(11);
  for (int history = 0; history < 1000; ++history) {
    const ElamModel model = model_of(any_loop(random, history % 5 == 0), any_parameters(random, 0.02));
    const double span = model.yu() - model.y0(), mean_slope = span / (model.xu() - model.x0());
    bool up = true;
    double x = model.x0(), y = model.y0();
    for (int turn = 0; turn < 8; ++turn) {
      const ElamCurve curve(model, up, x, y);
      const double goal = up ? model.xu() : model.x0();
      for (int k = 0; k < 6; ++k) {
        const double at = x + (goal - x) * random(0.0, 1.0);
        const double out = curve.output(at);
        REQUIRE(curve.output(curve.input(out)) == Approx(out).margin(1e-9 * span));
        const double h = 1e-3;
        const double slope = std::abs(curve.output(at + h) - curve.output(at - h)) / (2 * h);
        const double left = std::abs(out - curve.output(at - h)) / h;
        if (std::min(slope, left) > 1e-3 * mean_slope) REQUIRE(curve.input(out) == Approx(at).margin(1e-6));
        const double level = y + ((up ? model.yu() : model.y0()) - y) * random(0.0, 1.0);
        INFO("history " << history << " turn " << turn << (up ? " up" : " down") << " from " << x << ", " << y);
        REQUIRE(curve.output(curve.input(level)) == Approx(level).margin(1e-9 * span));
      }
      x += (goal - x) * random(0.05, 0.95);
      y = curve.output(x);
      up = !up;
    }
  }
}

TEST_CASE("branches are monotone and meet both ends, whatever the split") {
  Random random(12);
  for (int i = 0; i < 300; ++i) {
    ElamParameters p = any_parameters(random, 0.0);
    if (i % 7 == 0) p.alpha_d = i % 2;  // degenerate pieces
    if (i % 7 == 1) p.beta_d = i % 2;
    if (i % 7 == 2) p.beta_a = i % 2;
    if (i % 7 == 3) p.alpha_a1 = 0.0, p.alpha_a0 = i % 2;
    const ElamModel model = model_of(any_loop(random, i % 3 == 0), p);
    for (const bool up : {true, false}) {
      const double x = random(model.x0(), model.xu());
      const double y = random(model.ascending(x), std::max(model.ascending(x), model.descending(x)));
      const ElamCurve curve(model, up, x, y);
      CHECK(curve.output(x) == y);
      CHECK(curve.output(up ? model.xu() : model.x0()) == (up ? model.yu() : model.y0()));
      CHECK(curve.input(y) == x);
      CHECK(curve.input(up ? model.yu() : model.y0()) == (up ? model.xu() : model.x0()));
      double last = model.y0() - 1.0, last_x = model.x0() - 1.0;
      for (int k = 0; k <= 500; ++k) {
        const double share = k / 500.0;
        const double at = up ? x + (model.xu() - x) * share : model.x0() + (x - model.x0()) * share;
        REQUIRE(curve.output(at) >= last - 1e-12);
        last = curve.output(at);
        const double level = up ? y + (model.yu() - y) * share : model.y0() + (y - model.y0()) * share;
        REQUIRE(curve.input(level) >= last_x - 1e-9);
        last_x = curve.input(level);
      }
    }
  }
}

TEST_CASE("the split point is where Eqs (14), (15), (21), (22) put it, and on the curve") {
  const ElamModel model = model_of(paper_loop(), kPrinted);
  const ElamCurve down(model, false, 40.0, 3.2);
  CHECK(down.split_x() == Approx(0.7957 * 40.0));
  CHECK(down.split_y() == Approx(0.9991 * 3.2));
  CHECK(down.output(down.split_x()) == Approx(down.split_y()));
  const ElamCurve up(model, true, 20.0, 2.8);
  CHECK(up.split_x() == Approx(-0.0072 * 40.0 * 40.0 + 0.6031 * 40.0 + 20.0));
  CHECK(up.split_y() == Approx(0.3382 * (3.49 - 2.8) + 2.8));
  CHECK(up.output(up.split_x()) == Approx(up.split_y()));
  // Eq. (17) worked by hand at x = 36: x_P = 31.828 + (60 - 31.828) (36 - 31.828) / (40 - 31.828).
  const double xp = 31.828 + 28.172 * 4.172 / 8.172, psd = model.descending(31.828);
  CHECK(down.output(36.0) ==
        Approx(down.split_y() + (3.2 - down.split_y()) * (model.descending(xp) - psd) / (3.49 - psd)));
  // Eq. (19) at x = 10.
  CHECK(down.output(10.0) == Approx(model.descending(10.0) * down.split_y() / psd));
}

TEST_CASE("[A6] formulas on external branches by default, the patterns themselves with exact_outer") {
  const Loop loop = paper_loop();
  ElamParameters off = kPrinted;
  off.beta_d = 0.9;
  const ElamModel literal = model_of(loop, off), exact = model_of(loop, off, true);
  const ElamCurve a(literal, false, 60.0, 3.49), b(exact, false, 60.0, 3.49), c(exact, true, 0.0, 0.0);
  CHECK(std::abs(a.output(30.0) - literal.descending(30.0)) > 0.05);
  for (std::size_t i = 0; i < loop.x.size(); ++i) {
    CHECK(b.output(loop.x[i]) == Approx(loop.down[i]).margin(1e-9));
    CHECK(c.output(loop.x[i]) == Approx(loop.up[i]).margin(1e-9));
    CHECK(b.input(b.output(loop.x[i])) == Approx(loop.x[i]).margin(1e-5));
  }
  // Inner branches are the same in both readings.
  CHECK(ElamCurve(exact, false, 40, 3.2).output(20) == ElamCurve(literal, false, 40, 3.2).output(20));
  // An external branch that starts a little off still meets its start.
  const ElamCurve d(exact, false, 59.8, 3.45);
  CHECK(d.output(59.8) == 3.45);
  CHECK(d.output(d.input(3.0)) == Approx(3.0));
  // The split may be that of a turn at xu though the turn was read lower.
  const ElamCurve e(literal, false, 57.0, 3.48, 60.0);
  CHECK(e.split_x() == Approx(0.7957 * 60.0));
  CHECK(e.output(57.0) == 3.48);
  CHECK(e.output(e.input(3.2)) == Approx(3.2));
}

TEST_CASE("[A12] saturated patterns are linear between the two points") {
  Loop loop;
  for (int i = 0; i <= 6; ++i) {
    loop.x.push_back(10.0 * i);
    loop.up.push_back(0.5 * i);
    loop.down.push_back(i == 0 ? 0.0 : 3.0);  // yu from 10 psi on
  }
  const ElamModel model = model_of(loop, {0.5, 0.8, 0.0, 0.5, 0.5});
  const ElamCurve curve(model, false, 60.0, 3.0);
  for (double x = 30.0; x <= 60.0; x += 5.0) {
    CHECK(curve.output(x) == Approx(2.4 + 0.6 * (x - 30.0) / 30.0));
    CHECK(curve.input(curve.output(x)) == Approx(x));
  }
  for (int i = 0; i < 6; ++i) loop.down[static_cast<std::size_t>(i)] = 0.0;  // P_d(x_sd) = y0
  const ElamModel flat = model_of(loop, {0.5, 0.8, 0.0, 0.5, 0.5});
  const ElamCurve low(flat, false, 60.0, 3.0);
  CHECK(low.output(15.0) == Approx(1.2));
  CHECK(low.input(1.2) == Approx(15.0));
}

TEST_CASE("turning points outside the range are brought in, others refused") {
  const ElamModel model = model_of(paper_loop(), kPrinted);
  CHECK(ElamCurve(model, true, -3.0, -0.2).output(-1.0) == 0.0);
  CHECK(ElamCurve(model, true, 10.0, 9.0).output(20.0) == 3.49);
  CHECK(ElamCurve(model, false, 70.0, 3.6).output(60.0) == 3.6);  // a drifted end is met as measured
  CHECK(ElamCurve(model, false, 20.0, -0.1).output(10.0) == 0.0);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_THROWS_AS(ElamCurve(model, true, bad, 1.0), std::invalid_argument);
    CHECK_THROWS_AS(ElamCurve(model, true, 1.0, bad), std::invalid_argument);
  }
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

TEST_CASE("curves meet their split points exactly") {
  Random random(23);
  for (int trial = 0; trial < 300; ++trial) {
    const ElamModel model = model_of(any_loop(random, false), any_parameters(random, 0.02));
    const double x = random(6.0, 66.0);
    const double y = random(model.ascending(x), std::max(model.ascending(x), model.descending(x)));
    const ElamCurve down(model, false, x, y);
    CAPTURE(trial, x, y);
    CHECK(down.output(down.split_x()) == down.split_y());
    CHECK(down.input(down.split_y()) >= down.split_x() - 1e-12);
    CHECK(down.input(down.split_y()) == Approx(down.split_x()).epsilon(1e-12));
  }
}
