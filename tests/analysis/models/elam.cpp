#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/models/elam.h"
#include "analysis/models/model_json.h"
#include "tests/analysis/support/fit_samples.h"
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

TEST_CASE("ELAM: direct and inverse cancel along 1000 random histories with interrupted branches") {
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

TEST_CASE("ELAM: branches are monotone and meet both ends, for any split") {
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

TEST_CASE("ELAM: the split point follows Eqs (14), (15), (21) and (22), and lies on the curve") {
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

TEST_CASE("ELAM: external branches follow the formulas by default, and the patterns with exact_outer") {
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

TEST_CASE("ELAM: saturated patterns are linear between the two points of a piece") {
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

TEST_CASE("ELAM: turning points outside the range are moved into it, and non-finite ones are refused") {
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

TEST_CASE("ELAM: the inverse is right for a split within rounding of a rise's start or end") {
  // From the lowest input: split at 1e6 + 0.5 and at all but a billionth of the rise.
  const ElamModel late = far_line(0.5, 0.5, 1.0 - 1e-12);
  CHECK(ElamCurve(late, true, 1e6, 0.0).split_x() == 1e6 + 0.5);
  CHECK(ElamCurve(late, true, 1e6, 0.0).input(1.0 - 0.5e-12) == 1e6 + 1.0);
  CHECK(ElamCurve(late, true, 1e6, 0.0).input(0.5) == Approx(1e6 + 0.25).epsilon(1e-15));
  const ElamModel early = far_line(0.5, 0.5, 1e-12);
  CHECK(ElamCurve(early, true, 1e6, 0.0).input(0.5e-12) == 1e6 + 0.5);
  CHECK(ElamCurve(early, true, 1e6, 0.0).input(0.5) == Approx(1e6 + 0.75).epsilon(1e-15));
}

TEST_CASE("ELAM: curves pass exactly through their split points") {
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

// ELAM's further pieces and its memory by hand, on a straight loop: 60 psi are 3 V.

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

TEST_CASE("ELAM pieces: descending pieces, even in x, rise in proportion to their weights on each side") {
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

TEST_CASE("ELAM pieces: ascending pieces, even in y, are as long as their weights on each side") {
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

TEST_CASE("ELAM pieces: a branch starting exactly 1 % of the range from its end is external") {
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

TEST_CASE("ELAM memory: a branch closes its loop with scaled outputs, then continues the previous branch") {
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

// ELAM with more than one split point a branch.

namespace {

ElamModel any_model(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.02, 0.98);
  const double u = share(random), v = share(random);
  return model_of(paper_loop(), {share(random), share(random), (v - u) / 60.0, u, share(random)}, share(random) < 0.3);
}

// `splits` split points with pieces up to e^`most` larger or smaller.
ElamPieces any_pieces(std::mt19937& random, int splits, double most) {
  std::uniform_real_distribution<double> log(-most, most);
  ElamPieces pieces;
  for (int i = 1; i < splits; ++i) {
    (random() % 2 == 0 ? pieces.descending_low : pieces.descending_high).push_back(log(random));
    (random() % 2 == 0 ? pieces.ascending_low : pieces.ascending_high).push_back(log(random));
  }
  return pieces;
}

}  // namespace

TEST_CASE("ELAM pieces: equal weights give the paper's model, with one split bit for bit") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0.0, 60.0);
  for (int trial = 0; trial < 200; ++trial) {
    const ElamModel model = any_model(random);
    const ElamPieces same = any_pieces(random, 2 + trial % 7, 0.0);
    const bool ascending = trial % 2 == 0;
    const double x = any(random), y = model.descending(x);
    const ElamCurve paper(model, ascending, x, y);
    const ElamPiecedCurve one(model, {}, ascending, x, y), many(model, same, ascending, x, y);
    for (int k = 0; k <= 60; ++k) {
      CHECK(one.output(k) == paper.output(k));
      CHECK(one.input(0.06 * k) == paper.input(0.06 * k));
      CHECK(many.output(k) == Approx(paper.output(k)).margin(1e-12));
    }
  }
}

TEST_CASE("ELAM pieces: outputs never fall, meet both ends and can be inverted, with and without memory") {
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const ElamModel elam = any_model(random);
    const ElamHysteresis model(elam, trial % 2 == 0, any_pieces(random, 1 + trial % 8, kMaxPieceLog));
    const double span = elam.yu() - elam.y0();
    const auto state = model.state();
    const std::vector<double> inputs = random_inputs(random, 8, 0.0, 60.0, 5);
    for (const double x : inputs) {
      state->go(x);
      const double here = state->output_at(x);
      double below = elam.y0();
      for (int k = 0; k <= 60; k += 3) {
        const double y = state->output_at(k);
        CHECK(y >= below - 1e-12 * span);
        below = y;
        CHECK(state->output_at(state->input_at(y)) == Approx(y).margin(1e-9 * span));
      }
      CHECK(state->output_at(0.0) == Approx(std::min(here, elam.y0())).margin(1e-12));
      CHECK(state->output_at(60.0) == Approx(std::max(here, elam.yu())).margin(1e-12));
    }
  }
}

TEST_CASE("ELAM splits: more splits fit data that one split cannot, and never fit worse") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 4; ++trial) {
    const ElamHysteresis plant(model_of(paper_loop(), kPrinted), false, any_pieces(random, 3, 0.7));
    FitData data = paper_both();
    for (History& history : data.histories) history.y = predict(plant, history.x);
    const double one = identify("elam", data, {}).j;
    for (const int splits : {2, 3, 5}) {
      const ModelFit fit = identify("elam", data, {.splits = splits});
      INFO("trial " << trial << ", " << splits << " splits, J " << fit.j << ", with one " << one);
      CHECK(fit.j <= one * (1.0 + 1e-9));
      if (splits == 3) CHECK(fit.j < 0.05 * one);
      CHECK(fit.model->parameters().size() == 5 + 2 * static_cast<std::size_t>(splits - 1));
    }
  }
  const FitData noisy = paper_both(0.03, 0.02);
  const double one = identify("elam", noisy, {}).j;
  for (int splits = 2; splits <= kMaxSplits; ++splits) {
    const ModelFit fit = identify("elam", noisy, {.splits = splits});
    INFO(splits << " splits");
    CHECK(fit.j <= one * (1.0 + 1e-9));
    const auto again = model_from_json(model_json(*fit.model));
    CHECK(model_json(*again) == model_json(*fit.model));
    CHECK(predict(*again, noisy.histories[0].x) == predict(*fit.model, noisy.histories[0].x));
  }
}

TEST_CASE("ELAM splits: an invalid number of splits and inconsistent pieces are refused") {
  const FitData data = paper_both();
  for (const int splits : {0, 9}) CHECK_THROWS_AS(identify("elam", data, {.splits = splits}), std::invalid_argument);
  const ElamModel model = model_of(paper_loop(), kPrinted);
  CHECK_THROWS_AS(ElamHysteresis(model, false, {{0.1}, {}, {}, {}}), std::invalid_argument);
  CHECK_THROWS_AS(ElamHysteresis(model, false, {{2.1}, {}, {0.0}, {}}), std::invalid_argument);
  nlohmann::ordered_json json = model_json(ElamHysteresis(model, false, {{0.1}, {}, {}, {-0.2}}));
  json["options"]["splits"] = 3;
  CHECK_THROWS_WITH(model_from_json(json), Catch::Contains("\"splits\""));
  json["pieces"].erase("ascending_low");
  CHECK_THROWS_WITH(model_from_json(json), Catch::Contains("\"ascending_low\""));
}

namespace {

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// Goes along turning points in 7 steps each and says where it came out.
std::vector<double> walk(ModelState& state, std::initializer_list<double> turns) {
  std::vector<double> outputs;
  double x = turns.size() > 0 ? *turns.begin() : 0.0;
  for (const double turn : turns) {
    for (int k = 1; k <= 7; ++k) {
      state.go(x + (turn - x) * k / 7);
      outputs.push_back(state.output_at(x + (turn - x) * k / 7));
    }
    x = turn;
  }
  return outputs;
}

}  // namespace

TEST_CASE("ELAM: in paper mode outputs equal the paper's curves bit for bit") {
  Random random(8);
  for (int trial = 0; trial < 100; ++trial) {
    const ElamHysteresis model(any_model(random.engine));
    const ElamModel& elam = model.elam();
    const auto state = model.state();
    ElamCurve curve(elam, true, elam.x0(), elam.y0());
    double x = elam.x0(), y = elam.y0();
    for (int step = 0; step < 60; ++step) {
      const double to = random(elam.x0(), elam.xu());
      if ((to > x) != curve.ascending()) curve = ElamCurve(elam, to > x, x, y);
      x = to;
      y = curve.output(x);
      REQUIRE(same_bits(state->output_at(to), y));
      state->go(to);
      REQUIRE(same_bits(state->output_at(to), y));
    }
  }
}

TEST_CASE("ELAM memory: an inner loop closes and does not affect later outputs") {
  const ElamModel paper = model_of(paper_loop(), kPrinted);
  const ElamHysteresis with(paper, true), without(paper);
  // 20 to 40 psi cycled inside a rise to 50.
  const auto state = with.state(), plain = with.state(), forgetful = without.state();
  walk(*state, {0, 40});
  const double top = state->output_at(40);
  walk(*plain, {0, 40});
  for (int cycle = 0; cycle < 3; ++cycle) {
    walk(*state, {40, 20});
    const double bottom = state->output_at(20);
    walk(*state, {20, 33, 26, 33});
    CHECK(state->output_at(40) == Approx(top).margin(1e-12));
    walk(*state, {33, 40});
    CHECK(state->output_at(40) == Approx(top).margin(1e-12));
    CHECK(state->output_at(20) == Approx(bottom).margin(1e-12));
  }
  for (const double x : {41.0, 45.0, 50.0, 60.0})
    CHECK(state->output_at(x) == Approx(plain->output_at(x)).margin(1e-12));
  // The paper's model drifts [A10].
  walk(*forgetful, {0, 40});
  const double start = forgetful->output_at(40);
  for (int cycle = 0; cycle < 3; ++cycle) walk(*forgetful, {40, 20, 40});
  CHECK(std::abs(forgetful->output_at(40) - start) > 0.01 * 3.49);
  // On the paper's own sequences there is nothing to remember.
  const auto a = with.state(), b = without.state();
  for (const auto* turns : {&kDescendingTurns, &kAscendingTurns}) {
    for (const double x : levels_of(*turns)) {
      a->go(x);
      b->go(x);
      REQUIRE(same_bits(a->output_at(x), b->output_at(x)));
    }
  }
}

TEST_CASE("ELAM: a measured turning point is where the next branch starts") {
  const ElamModel paper = model_of(paper_loop(), kPrinted);
  const ElamHysteresis model(paper);
  const auto state = model.state();
  state->go(30.0);
  state->measured(1.9);
  CHECK(state->output_at(30.0) == 1.9);
  CHECK(same_bits(state->output_at(12.0), ElamCurve(paper, false, 30.0, 1.9).output(12.0)));
  CHECK(same_bits(state->output_at(47.0), ElamCurve(paper, true, 30.0, 1.9).output(47.0)));
  state->go(59.9);
  state->measured(3.1);  // an external branch starts at the pattern's end
  CHECK(same_bits(state->output_at(30.0), ElamCurve(paper, false, 60.0, 3.49).output(30.0)));
  CHECK_THROWS_AS(state->measured(std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(state->go(std::nan("")), std::invalid_argument);
  state->reset();
  CHECK(same_bits(state->output_at(30.0), ElamCurve(paper, true, 0.0, paper.y0()).output(30.0)));
}

TEST_CASE("ELAM JSON: an invalid document is refused with the member named") {
  const ElamHysteresis model(model_of(paper_loop(), kPrinted));
  const auto refused = [&](const std::string& path, const nlohmann::ordered_json& value, const std::string& word) {
    nlohmann::ordered_json json = model_json(model);
    const nlohmann::ordered_json::json_pointer at(path);
    if (value.is_null())
      json[at.parent_pointer()].erase(at.back());
    else
      json[at] = value;
    INFO(path);
    CHECK_THROWS_WITH(model_from_json(json), Catch::Contains(word));
  };
  refused("/x", nullptr, "\"x\"");
  refused("/ascending", "steep", "\"ascending\"");
  refused("/descending", nlohmann::ordered_json::array({1.0}), "\"descending\"");
  refused("/parameters/beta_a", nullptr, "\"beta_a\"");
  refused("/parameters/alpha_d", "half", "\"alpha_d\"");
  refused("/options/memory", 1, "\"memory\"");
  refused("/options/splits", 7, "\"pieces\"");
  refused("/ascending/30", 9.0, "ends");
}

TEST_CASE("ELAM: a joint free-run fit has a smaller free-run error than the separate fit") {
  // A plant that no ELAM is: with the memory that the fit is not told of, and other splits up and down.
  const ElamHysteresis truth(model_of(paper_loop(), {0.7, 0.95, -0.004, 0.5, 0.4}, true), true);
  const auto state = truth.state();
  const auto plant = [&](double x) {
    state->go(x);
    return state->output_at(x);
  };
  const std::vector<double> way = levels_of({0, 60, 0, 50, 10, 40, 20, 50, 0, 60, 20, 50, 30, 60, 0});
  const FitData data{{drive("free", way, plant, 0.03, 4)}, truth.elam().ascending, truth.elam().descending};
  const ModelFit separate = identify("elam", data), joint = identify("elam", data, {.free_run = true});
  const std::vector<double> y = predict(*separate.model, way);
  double j = 0.0;
  for (std::size_t i = 1; i < y.size(); ++i) j += std::pow(y[i] - data.histories[0].y[i], 2);
  INFO("free-run J " << joint.j << ", separate " << j);
  CHECK(joint.j < j);
  CHECK(joint.j > 0.3 * 0.03 * 0.03 * joint.samples);
}
