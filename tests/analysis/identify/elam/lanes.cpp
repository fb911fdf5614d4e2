#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/elam/search.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

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
struct Example {
  ElamModel model;
  ElamSamples samples;
};
Example lanes_example(bool uniform, double top) {
  Loop loop = paper_loop();
  for (std::size_t i = 1; i + 1 < loop.x.size(); i += 3)
    if (!uniform) loop.x[i] += 0.7;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (double& y : loop.up) y = std::min(y, top);
  for (double& y : loop.down) y = std::min(y, top);
  Example result{model_of(loop, kPrinted), {}};
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
      Example e = lanes_example(uniform, top);
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
  Example e = lanes_example(true, 9.0);
  CHECK(fit_descending(e.model, {}) == 0.0);
  CHECK(fit_ascending(e.model, {}) == 0.0);
  CurveSamples one;
  one.x_turn = 30.0;
  one.y_turn = 2.0;
  one.x = {31.0};
  one.y = {2.1};
  one.weight = {1.0};
  CHECK(fit_ascending(e.model, std::span(&one, 1)) == Approx(0.0).margin(1e-9));
  one.x = {29.0};
  one.y = {1.9};
  CHECK(fit_descending(e.model, std::span(&one, 1)) == Approx(0.0).margin(1e-9));
}
