// ELAM on few samples far from any model, where J has several minima: no place of a grid over the whole box is lower.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/elam/identify.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

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

TEST_CASE("identification of few noisy samples: no place of a grid over all parameters has a lower J") {
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
