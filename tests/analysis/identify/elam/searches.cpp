// The samples of a search: J is merged exactly, and long data are thinned independently of their period.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/elam/search.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

TEST_CASE("ELAM samples: those at one point of one curve are merged without changing J") {
  const ElamModel model = model_of(paper_loop(), kPrinted);
  std::vector<TaxelBranch> branches{{false, {60, 40, 20, 0}, {3.49, 3.1, 2.4, 0.1}},
                                    {false, {60, 20, 40, 0}, {3.48, 2.2, 3.3, 0.0}},  // external: the same curve
                                    {false, {50, 40, 20, 0}, {3.40, 3.0, 2.1, 0.2}},
                                    {true, {0, 20, 60}, {0.0, 1.0, 3.4}}};
  const ElamSamples samples = collect_samples(model, branches);
  REQUIRE(samples.descending.size() == 2);
  REQUIRE(samples.ascending.size() == 1);
  CHECK(samples.descending[0].x == std::vector<double>{0, 20, 40});
  CHECK(samples.descending[0].weight == std::vector<double>{2, 2, 2});
  CHECK(samples.descending[1].weight == std::vector<double>{1, 1, 1});
  double plain = 0.0, distinguished_cost = samples.descending_constant;
  for (const TaxelBranch& branch : branches) {
    if (branch.ascending) continue;
    for (std::size_t i = 1; i < branch.volts.size(); ++i) plain += std::pow(2.0 - branch.volts[i], 2);
  }
  for (const CurveSamples& curve : samples.descending)
    for (std::size_t i = 0; i < curve.x.size(); ++i)
      distinguished_cost += curve.weight[i] * std::pow(2.0 - curve.y[i], 2);
  CHECK(distinguished_cost == Approx(plain).epsilon(1e-12));
}

TEST_CASE("thinning: keeps the requested share of samples, for any period of the data") {
  std::vector<CurveSamples> curves;
  for (int c = 0; c < 1000; ++c) {
    CurveSamples& curve = curves.emplace_back();
    for (int i = 0; i < 100; ++i) {
      curve.x.push_back(i);
      curve.y.push_back(c);
      curve.weight.push_back(1.0 + i);
    }
  }
  std::vector<CurveSamples> whole = curves;
  thin(whole, 100000);
  CHECK(whole.size() == 1000);
  CHECK(whole.back().x.size() == 100);
  thin(curves, 5000);
  std::size_t count = 0;
  double sum = 0.0, least = 100.0;
  for (const CurveSamples& curve : curves) {
    REQUIRE(curve.weight.size() == curve.x.size());
    count += curve.x.size();
    least = std::min(least, static_cast<double>(curve.x.size()));
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      sum += curve.x[i];
      CHECK(curve.weight[i] == 1.0 + curve.x[i]);
    }
  }
  CHECK(std::abs(static_cast<double>(count) - 5000.0) < 5.0);
  CHECK(least >= 4.0);  // 5 of each 100
  CHECK(sum / static_cast<double>(count) == Approx(49.5).margin(0.5));
}

// ELAM's searches for its rising half: candidates beside each other, and where nothing depends on an unknown.

namespace {

// Rises from the lowest input and from two turns inside, of a model drawn anywhere, with noise.
struct Rises {
  ElamModel model = model_of(paper_loop(), {});
  std::vector<CurveSamples> curves;
  Rises(Random& random, double noise) {
    const double u = random(0.0, 1.0), v = random(0.0, 1.0);
    model.parameters = {0.5, 0.5, (v - u) / 60.0, u, random(0.0, 1.0)};
    for (const double turn : {0.0, random(10.0, 25.0), random(30.0, 45.0)}) {
      CurveSamples& own = curves.emplace_back();
      own.x_turn = turn;
      own.y_turn = turn == 0.0 ? model.y0() : model.descending(turn);
      const ElamCurve curve(model, true, own.x_turn, own.y_turn);
      for (int i = 1; i <= 6; ++i) {
        own.x.push_back(turn + (60.0 - turn) * i / 6.5);
        own.y.push_back(curve.output(own.x.back()) + random(-noise, noise));
        own.weight.push_back(1.0 + i % 3);
      }
    }
  }
};

}  // namespace

TEST_CASE("ELAM search: descent lowers J, and parallel candidates end where each ends alone") {
  Random random(12);
  for (int problem = 0; problem < 6; ++problem) {
    CAPTURE(problem);
    const Rises rises(random, problem % 3 == 0 ? 0.3 : 0.02);
    const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
    AscendingSearch search(lanes, 8), alone(lanes, 1);
    std::vector<Value> values(8);
    for (Value& value : values) value.at = {random(0.0, 1.0), random(0.0, 1.0), random(0.0, 1.0)};
    search.evaluate(values);
    const std::vector<Value> before = values;
    search.descend(values, 8, Gradient::kSpace);
    for (std::size_t i = 0; i < values.size(); ++i) {
      CHECK(values[i].j <= before[i].j);
      for (const double unknown : values[i].at) CHECK((unknown >= 0.0 && unknown <= 1.0));
      Value own = before[i];
      alone.descend(std::span(&own, 1), 8, Gradient::kSpace);
      CHECK(own.j == Approx(values[i].j).epsilon(1e-9));
      Value plane = before[i];
      alone.descend(std::span(&plane, 1), 8, Gradient::kPlane);
      CHECK(plane.at[2] == before[i].at[2]);
    }
    CHECK(AscendingSearch(lanes, 24).evolve(values[0]).j <= values[0].j);
  }
}

TEST_CASE("ELAM search: more candidates than lanes are refused") {
  Random random(13);
  const Rises rises(random, 0.1);
  const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
  AscendingSearch search(lanes, 9);  // makes 16
  std::vector<Value> many(17);
  CHECK_THROWS_AS(search.evaluate(many), std::invalid_argument);
  CHECK_THROWS_AS(search.descend(many, 1, Gradient::kPlane), std::invalid_argument);
  AscendingSearch eight(lanes, 8);
  CHECK_THROWS_AS(eight.evaluate(std::span(many).first(9)), std::invalid_argument);
  CHECK_NOTHROW(eight.evaluate(std::span(many).first(8)));
}

TEST_CASE("ELAM search: parameters on which J does not depend stay unchanged") {
  Random random(14);
  const Rises rises(random, 0.1);
  Value start;
  start.at = {0.2, 0.4, 0.7};
  for (const Gradient gradient : {Gradient::kPlane, Gradient::kSpace}) {
    const LaneProblem none = lane_problem(rises.model, {}, true);
    AscendingSearch search(none, 24);
    Value there = start;
    search.descend(std::span(&there, 1), 3, gradient);
    CHECK(there.at == start.at);
    CHECK(there.j == 0.0);
    CHECK(search.evolve(there).at == start.at);
    // Rises from the lowest input are split at v alone.
    const LaneProblem longest = lane_problem(rises.model, std::span(rises.curves).first(1), true);
    AscendingSearch of_one(longest, 1);
    there = start;
    of_one.descend(std::span(&there, 1), 5, gradient);
    CHECK(there.at[0] == start.at[0]);
    CHECK(there.at[1] != start.at[1]);
  }
}

// ELAM on few samples far from any model, where J has several minima: no place of a grid over the whole box is lower.

namespace {

// Branches of three to five samples from inner turns, and one external one of each direction; outputs `noise` V off a
// model drawn anywhere.
std::vector<TaxelBranch> drawn_branches(Random& random, double noise) {
  const Loop loop = paper_loop();
  const double u = random(0.1, 0.9), v = random(0.1, 0.9);
  const ElamModel truth = model_of(loop, {random(0.1, 0.9), random(0.1, 0.9), (v - u) / 60.0, u, random(0.1, 0.9)});
  std::vector<TaxelBranch> branches;
  for (const bool up : {false, true}) {
    for (const double turn : {up ? 0.0 : 60.0, random(15.0, 45.0), random(10.0, 50.0)}) {
      const ElamCurve outer(truth, !up, up ? truth.xu() : truth.x0(), up ? truth.yu() : truth.y0());
      const double start = turn == (up ? 0.0 : 60.0) ? (up ? truth.y0() : truth.yu()) : outer.output(turn);
      const ElamCurve curve(truth, up, turn, start);
      TaxelBranch branch{up, {turn}, {start}};
      const double end = up ? 60.0 : 0.0;
      const int samples = 3 + static_cast<int>(random(0.0, 2.99));
      for (int i = 1; i <= samples; ++i) {
        const double x = turn + (end - turn) * i / samples;
        branch.pressure_psi.push_back(x);
        branch.volts.push_back(curve.output(x) + random(-noise, noise));
      }
      branches.push_back(branch);
    }
  }
  return branches;
}

double j_of(const ElamModel& like, const ElamParameters& parameters, const std::vector<TaxelBranch>& branches) {
  ElamModel model = like;
  model.parameters = parameters;
  return scored(model, branches).j_v2;
}

}  // namespace

TEST_CASE("identify_elam: on few noisy samples no point of a parameter grid has a lower J") {
  Random random(7);
  for (int problem = 0; problem < 12; ++problem) {
    INFO("problem " << problem);
    const std::vector<TaxelBranch> branches = drawn_branches(random, problem % 2 == 0 ? 0.2 : 0.8);
    const ElamModel like = model_of(paper_loop(), {});
    const ElamFit fit = identify_elam(like.ascending, like.descending, branches, {}, false);
    CHECK(fit.j_v2 == Approx(j_of(like, fit.model.parameters, branches)).epsilon(1e-9));
    // J is the sum of what the falling and the rising branches have, each with parameters of its own.
    double falling = fit.j_v2, rising = fit.j_v2;
    for (int i = 0; i <= 20; ++i)
      for (int k = 0; k <= 20; ++k) {
        ElamParameters p = fit.model.parameters;
        p.alpha_d = 0.05 * i;
        p.beta_d = 0.05 * k;
        falling = std::min(falling, j_of(like, p, branches));
      }
    for (int i = 0; i <= 8; ++i)
      for (int k = 0; k <= 8; ++k)
        for (int m = 0; m <= 8; ++m) {
          ElamParameters p = fit.model.parameters;
          p.alpha_a0 = 0.125 * i;
          p.alpha_a1 = 0.125 * (k - i) / 60.0;
          p.beta_a = 0.125 * m;
          rising = std::min(rising, j_of(like, p, branches));
        }
    CHECK(fit.j_v2 <= falling * (1.0 + 1e-9));
    CHECK(fit.j_v2 <= rising * (1.0 + 1e-9));
  }
}

// What ELAM's searches look at, by hand: units of an even grid, ends that no parameter moves, curves of one turn.

using namespace tactbench::analysis;

TEST_CASE("ELAM lanes: scaling, separated end samples and curves per turning point match hand-computed values") {
  const std::vector<double> x{10, 20, 30, 40}, y{1, 2, 4, 5};
  const ElamModel model{PatternCurve(x, y, 1.0, 5.0), PatternCurve(x, y, 1.0, 5.0), {}, {}};
  // Down from (30, 3): at 10 psi the end, 1 V, at 30 and above the turn; between them in order.
  const std::vector<CurveSamples> down{{30, 3, {25, 10, 15, 30, 35}, {2, 1.5, 1.25, 2, 3}, {1, 2, 3, 4, 5}}};
  const LaneProblem falls = lane_problem(model, down, false);
  CHECK((falls.x0 == 0.0 && falls.xu == 3.0 && falls.y0 == 1.0 && falls.yu == 5.0));
  CHECK(falls.constant == 2 * 0.25 + 4 * 1.0);
  CHECK(falls.x == std::vector<double>{0.5, 1.5});
  CHECK(falls.y == std::vector<double>{1.25, 2});
  CHECK(falls.weight == std::vector<double>{3, 1});
  CHECK(falls.pattern == std::vector<double>{0.5, 2});  // 1.5 and 3 V less 1
  REQUIRE(falls.curves.size() == 1);
  CHECK((falls.curves[0].first == 0 && falls.curves[0].end == 2));
  CHECK((falls.curves[0].x_turn == 2.0 && falls.curves[0].y_turn == 3.0 && falls.curves[0].rise == 2.0));
  CHECK((falls.curves[0].length == 1.0 && falls.curves[0].share == Approx(1.0 / 3.0)));
  CHECK(falls.curves[0].x_pattern == 1.5);
  // Up from (15, 6), which lies above the range: 5 V.
  const std::vector<CurveSamples> up{{15, 6, {40, 15, 20}, {4, 4.5, 5}, {1, 2, 1}}, {20, 0.5, {30}, {3}, {1}}};
  const LaneProblem rises = lane_problem(model, up, true);
  CHECK(rises.constant == 1.0 + 2 * 0.25);
  CHECK(rises.x == std::vector<double>{1, 2});
  CHECK(rises.pattern.empty());
  REQUIRE(rises.curves.size() == 2);
  CHECK((rises.curves[0].x_turn == 0.5 && rises.curves[0].y_turn == 5.0 && rises.curves[0].rise == 0.0));
  CHECK((rises.curves[0].x_pattern == 3.0 && rises.curves[0].length == 2.5));
  CHECK((rises.curves[1].first == 1 && rises.curves[1].end == 2 && rises.curves[1].rise == 4.0));
  CHECK((rises.curves[1].y_turn == 1.0 && rises.curves[1].x_pattern == 0.0));
}
