// ELAM's searches: their samples, their steps in lanes, their minima, and the parameters that data leave open.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/elam/search.h"
#include "analysis/identify/fit_models.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/models.h"
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

namespace {

constexpr std::size_t kCandidates = 64;

bool same_bits(std::span<const double> a, std::span<const double> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

// All that the two lane functions say about random candidates.
struct Answers {
  std::vector<double> alpha = std::vector<double>(kCandidates), descending = alpha, beta = alpha;
  AscendingLanes lanes;
  explicit Answers(const LaneProblem& ascending) : lanes(ascending, kCandidates) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit;
    for (std::size_t i = 0; i < kCandidates; ++i) {
      alpha[i] = i == 0 ? 0.0 : i == 1 ? 1.0 : unit(random);
      lanes.u[i] = i % 9 == 2 ? 0.0 : unit(random);
      lanes.v[i] = i % 11 == 3 ? 1.0 : unit(random);
      lanes.beta[i] = i % 13 == 4 ? 0.0 : i % 13 == 5 ? 1.0 : unit(random);
      lanes.split(i);
    }
  }
};

// The paper's loop with noise on its inner branches; `uniform` false: every third knot moved; `top` cuts it off.
struct LaneExample {
  ElamModel model;
  ElamSamples samples;
};
LaneExample lanes_example(bool uniform, double top) {
  Loop loop = paper_loop();
  for (std::size_t i = 1; i + 1 < loop.x.size(); i += 3)
    if (!uniform) loop.x[i] += 0.7;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (double& y : loop.up) y = std::min(y, top);
  for (double& y : loop.down) y = std::min(y, top);
  LaneExample result{model_of(loop, kPrinted), {}};
  Plant plant(result.model);
  std::vector<TaxelBranch> branches;
  for (const auto* turns : {&kDescendingTurns, &kAscendingTurns})
    for (std::size_t t = 1; t < turns->size(); ++t) {
      TaxelBranch branch{(*turns)[t] > (*turns)[t - 1], {}, {}};
      for (const double x : levels_of({(*turns)[t - 1], (*turns)[t]}, t % 2 == 0 ? 2.0 : 2.5)) {
        branch.pressure_psi.push_back(x);
        branch.volts.push_back(plant(x) + noise(random));
      }
      branches.push_back(std::move(branch));
    }
  result.samples = collect_samples(result.model, branches);
  return result;
}

double plain_j(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending) {
  double j = 0.0;
  for (const CurveSamples& samples : curves) {
    const ElamCurve curve(model, ascending, samples.x_turn, samples.y_turn);
    for (std::size_t i = 0; i < samples.x.size(); ++i)
      j += samples.weight[i] * std::pow(curve.output(samples.x[i]) - samples.y[i], 2);
  }
  return j;
}

}  // namespace

TEST_CASE("ELAM lanes: match the scalar model, with equal bits whatever slopes are asked for and whichever the lane") {
  for (const bool uniform : {true, false}) {
    for (const double top : {9.0, 2.9}) {
      LaneExample e = lanes_example(uniform, top);
      const LaneProblem down = lane_problem(e.model, e.samples.descending, false);
      const LaneProblem up = lane_problem(e.model, e.samples.ascending, true);
      CHECK(up.table.uniform() == uniform);
      Answers own(up);
      lane_descending(down, own.alpha, own.descending, own.beta);
      lane_ascending(own.lanes, kCandidates, Gradient::kNone);
      const std::vector<double> j = own.lanes.j;
      lane_ascending(own.lanes, kCandidates, Gradient::kPlane);
      CHECK(same_bits(own.lanes.j, j));
      const std::vector<double> plane = own.lanes.normal[1];
      lane_ascending(own.lanes, kCandidates, Gradient::kSpace);
      CHECK(same_bits(own.lanes.j, j));
      CHECK(same_bits(own.lanes.normal[1], plane));
      for (std::size_t i = 0; i < kCandidates; ++i) {
        ElamParameters& p = e.model.parameters;
        p = {own.alpha[i], own.beta[i], (own.lanes.v[i] - own.lanes.u[i]) / 60.0, own.lanes.u[i], own.lanes.beta[i]};
        INFO("candidate " << i);
        const double plain = plain_j(e.model, e.samples.descending, false);
        CHECK(own.descending[i] == Approx(plain).epsilon(1e-9).margin(1e-12));
        CHECK(own.lanes.j[i] == Approx(plain_j(e.model, e.samples.ascending, true)).epsilon(1e-9));
        for (const double off : {-1e-3, 1e-3}) {  // beta_d is the best one
          p.beta_d = std::clamp(own.beta[i] + off, 0.0, 1.0);
          CHECK(plain_j(e.model, e.samples.descending, false) >= plain * (1.0 - 1e-12));
        }
      }
      // The candidates the other way round: each in another lane, beside others.
      Answers turned = own;
      std::ranges::reverse(turned.alpha);
      for (std::vector<double>* list : {&turned.lanes.u, &turned.lanes.v, &turned.lanes.beta})
        std::ranges::reverse(*list);
      for (std::size_t i = 0; i < kCandidates; ++i) turned.lanes.split(i);
      lane_descending(down, turned.alpha, turned.descending, turned.beta);
      lane_ascending(turned.lanes, kCandidates, Gradient::kSpace);
      for (std::vector<double>* list : {&turned.descending, &turned.beta, &turned.lanes.j, &turned.lanes.right[2]})
        std::ranges::reverse(*list);
      CHECK(same_bits(turned.descending, own.descending));
      CHECK(same_bits(turned.beta, own.beta));
      CHECK(same_bits(turned.lanes.j, own.lanes.j));
      CHECK(same_bits(turned.lanes.right[2], own.lanes.right[2]));
    }
  }
}

TEST_CASE("ELAM search: accepts no curves, a single sample, or a branch that stops short") {
  LaneExample e = lanes_example(true, 9.0);
  CHECK(fit_descending(e.model, {}) == 0.0);
  CHECK(fit_ascending(e.model, {}) == 0.0);
  const CurveSamples rise{30, 2, {31}, {2.1}, {1}}, fall{30, 2, {29}, {1.9}, {1}};
  CHECK(fit_ascending(e.model, std::span(&rise, 1)) == Approx(0.0).margin(1e-9));
  CHECK(fit_descending(e.model, std::span(&fall, 1)) == Approx(0.0).margin(1e-9));
}

// Parameters that data do not determine are reported and chosen by a rule; determined ones do not change.

namespace {

const std::vector<double> kLoops{0, 60, 0, 60, 0, 60, 0};
const std::vector<std::string> kAll{"alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a"};

// Begun in mid-range: the first branch has no measured turn and is no inner one.
FitData begun_late(FitData data, int skipped) {
  History& cut = data.histories.front();
  cut.x.erase(cut.x.begin(), cut.x.begin() + skipped);
  cut.y.erase(cut.y.begin(), cut.y.begin() + skipped);
  cut.branches = branches_along(cut.x);
  return data;
}

}  // namespace

TEST_CASE("undetermined parameters: external loops alone leave all of ELAM open, at the pattern's middle") {
  for (const double noise : {0.0, 0.003, 0.02}) {
    const FitData data = paper_data(kLoops, noise);
    const ModelFit fit = identify("elam", data);
    INFO("noise " << noise);
    CHECK(fit.undetermined == kAll);
    const std::vector<ModelParameter> p = fit.model->parameters();
    CHECK(p[0].value == 0.5);
    CHECK(p[1].value == Approx(data.descending(30.0) / 3.49));
    CHECK(p[2].value == 0.0);
    CHECK(p[3].value == 0.5);
    CHECK(p[4].value == Approx(data.ascending(30.0) / 3.49));
    CHECK(fit.mean_error < 1.2 * noise + 1e-9);
  }
}

TEST_CASE("undetermined parameters: full cycles recorded from mid-range leave all of ELAM open") {
  for (const int skipped : {12, 42})  // at 24 psi, up or down
    CHECK(identify("elam", begun_late(paper_data(kLoops, 0.003), skipped)).undetermined == kAll);
}

TEST_CASE("undetermined parameters: inner branches leave none open, and settling changes none") {
  const FitData data = paper_both(0.032, 0.0205);
  CHECK(identify("elam", data).undetermined.empty());
  CHECK(identify("preisach", data).undetermined.empty());
  ElamModel model{data.ascending, data.descending, {}, {}};
  const ElamSamples samples = searched_samples(model, elam_branches_of(data));
  fit_descending(model, samples.descending);
  fit_ascending(model, samples.ascending);
  const ElamParameters found = model.parameters;
  CHECK(settle_undetermined(model, samples.descending, samples.descending_constant, false) == 0);
  CHECK(settle_undetermined(model, samples.ascending, samples.ascending_constant, true) == 0);
  CHECK(model.parameters.alpha_d == found.alpha_d);
  CHECK(model.parameters.beta_d == found.beta_d);
  CHECK(model.parameters.alpha_a1 == found.alpha_a1);
  CHECK(model.parameters.alpha_a0 == found.alpha_a0);
  CHECK(model.parameters.beta_a == found.beta_a);
}

TEST_CASE("undetermined parameters: Preisach on external loops alone spreads its weights, from any start") {
  const PreisachModel truth = random_preisach();
  FitData data = paper_data(kLoops);
  History& loops = data.histories.front();
  loops.y = predict(truth, loops.x);
  const std::vector<double> grid(loops.x.begin(), loops.x.begin() + 31), up(loops.y.begin(), loops.y.begin() + 31);
  const std::vector<double> down(loops.y.rend() - 61, loops.y.rend() - 30);
  data.ascending = PatternCurve(grid, up, up.front(), up.back());
  data.descending = PatternCurve(grid, down, up.front(), up.back());
  for (const bool by_input : {false, true}) {
    CAPTURE(by_input);
    const ModelFit fit = identify("preisach", data, {.by_input = by_input});
    CHECK(fit.undetermined == std::vector<std::string>{"w"});
    CHECK(fit.mean_error < 0.002 * fit.full_scale);
    // Weights above 0: the sparse vertex that non-negative least squares ends in has at most one a row and a column.
    CHECK(fit.model->parameters().size() > 2 * 30);
  }

  CHECK(identify("preisach", begun_late(data, 12)).undetermined == std::vector<std::string>{"w"});
}

TEST_CASE("score: every model is scored from measured turning points and in free run, in any fit mode") {
  const FitData data = paper_both(0.032, 0.0205);
  const ScoreOptions options{.noise = 0.016, .x_low = 0.0, .y_low = 0.0, .x_high = 60.0, .y_high = 3.49};
  for (const char* name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"}) {
    for (const bool free_run : {false, true}) {
      const ModelFit fit = identify(name, data, {.free_run = free_run, .starts = 1});
      const Score found = score(*fit.model, data.histories, options);
      ErrorSum both[2];
      for (const bool running : {false, true})
        for (const History& history : data.histories) {
          const std::vector<double> y = predict_history(*fit.model, history, running);
          for (std::size_t i = 1; i < y.size(); ++i) both[running ? 1 : 0].add(std::abs(y[i] - history.y[i]));
        }
      INFO(name << (free_run ? ", free run" : ""));
      CHECK(found.direct.mean() == Approx(both[0].mean()));
      CHECK(found.free_running.mean() == Approx(both[1].mean()));
      const bool by_inputs = name[0] != 'e' && std::string(name) != "poly";
      CHECK((found.direct.mean() == found.free_running.mean()) == by_inputs);
    }
  }
}

// Which member is taken of those that samples leave open, on straight patterns where it can be worked out by hand.

namespace {

const PatternCurve kStraight(std::vector<double>{0, 10}, std::vector<double>{0, 10}, 0.0, 10.0);

// Both pieces of a curve are straight. All samples lie on the piece that ends at 8 psi and 8 V (falling) or at 10 psi
// and 10 V (rising, from 2 psi and 2 V), 1 psi from that end, where the split in the middle of the pattern gives a
// slope of 1: they determine that piece's slope (1 - beta) / (1 - alpha) alone. The model has a slope of 1.1 and meets
// them.
struct OneSlope {
  bool ascending;
  int samples;
  ElamModel model{kStraight, kStraight, {}, {}};
  std::vector<CurveSamples> curves;
  OneSlope(bool up, int n) : ascending(up), samples(n) {
    // From 2 psi on, phi(8 psi) = 0.4.
    model.parameters = {0.4, 1.0 - 1.1 * 0.6, 0.01, 0.32, 1.0 - 1.1 * 0.6};
    const double turn = up ? 2.0 : 8.0, end = up ? 10.0 : 8.0;
    curves = {{turn, turn, {end - 1.0}, {end - 1.1}, {static_cast<double>(n)}}};
  }
  unsigned settle(double constant) { return settle_undetermined(model, curves, constant, ascending); }
  // J of the split in the middle, above the J of the model.
  [[nodiscard]] double gained() const { return samples * 0.1 * 0.1; }
};

}  // namespace

TEST_CASE("undetermined parameters: the middle is chosen if chance explains its J, else the nearest fitting point") {
  // 6 a parameter of J over degrees of freedom: 2 of 14 and 26 samples falling, 3 of 21 rising.
  for (const auto& [ascending, samples, share] :
       {std::tuple(false, 14, 12.0 / 12.0), std::tuple(false, 26, 12.0 / 24.0), std::tuple(true, 21, 18.0 / 18.0)}) {
    CAPTURE(ascending, samples);
    OneSlope chance(ascending, samples);
    CHECK(chance.settle(1.01 * chance.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& middle = chance.model.parameters;
    CHECK((ascending ? middle.beta_a : middle.beta_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a0 : middle.alpha_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a1 : 0.0) == Approx(0.0).margin(1e-12));

    OneSlope more(ascending, samples);
    const ElamParameters before = more.model.parameters;
    CHECK(more.settle(0.99 * more.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& near = more.model.parameters;
    if (ascending) {
      const double phi = near.alpha_a0 + 8.0 * near.alpha_a1;
      CHECK((1.0 - near.beta_a) / (1.0 - phi) == Approx(1.1).epsilon(1e-3));
      CHECK(near.beta_a > before.beta_a);
    } else {
      // The foot of the perpendicular from the middle on the line of one slope.
      const double way = (0.1 * 1.0 + 0.16 * 1.1) / (1.0 + 1.1 * 1.1);
      CHECK(near.alpha_d == Approx(0.4 + way).epsilon(1e-5));
      CHECK(near.beta_d == Approx(0.34 + 1.1 * way).epsilon(1e-5));
    }
  }
}

TEST_CASE("undetermined parameters: if J is 0 along a whole edge, the point nearest the middle is chosen") {
  // With beta 0 the piece below the split is flat, wherever the split lies above 2 psi: alpha is open, beta is not.
  ElamModel model{kStraight, kStraight, {0.9, 0.0, 0.0, 0.5, 0.5}, {}};
  const std::vector<CurveSamples> curves{{8, 8, {2}, {0}, {1}}};
  CHECK(settle_undetermined(model, curves, 0.0, false) == 0b1U);
  CHECK(model.parameters.alpha_d == Approx(0.5));
  CHECK(model.parameters.beta_d == 0.0);
}
