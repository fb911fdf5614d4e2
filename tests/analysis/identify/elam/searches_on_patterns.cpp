// ELAM on samples of models drawn anywhere, on patterns of many shapes: grids that are not even, clipped ends, steep
// middles, ranges that begin above 0. Where the searches ended when these were recorded, in sums.
#include <algorithm>

#include "analysis/identify/elam/identify.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

struct TwoPatterns {
  std::vector<double> x, up, down;
};

// Outputs from 0.7 to 3.7 V.
TwoPatterns patterns_of_shape(int shape) {
  TwoPatterns two;
  two.x = shape == 0   ? std::vector<double>{0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0, 49.0, 60.0}
          : shape == 1 ? std::vector<double>{5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0}
          : shape == 2 ? std::vector<double>{0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}
                       : std::vector<double>{2.0, 20.0, 22.0, 24.0, 40.0, 62.0};
  for (const double x : two.x) {
    const double share = (x - two.x.front()) / (two.x.back() - two.x.front());
    double up = share * (0.3 + 0.7 * share), down = share * (1.8 - 0.8 * share);
    if (shape == 1) up = std::max(0.0, 1.4 * up - 0.4), down = std::min(1.0, 1.2 * down);
    if (shape == 3 && x > 21.0 && x < 50.0) up += 0.25, down += 0.05;
    two.up.push_back(0.7 + 3.0 * up);
    two.down.push_back(0.7 + 3.0 * down);
  }
  two.up.back() = two.down.back() = 3.7;
  return two;
}

ElamModel drawn_model(Numbers& number, const TwoPatterns& two, bool exact_outer) {
  const double u = number(), v = number(), length = two.x.back() - two.x.front();
  const double alpha_d = number(), beta_d = number(), beta_a = number();
  return {PatternCurve(two.x, two.up, 0.7, 3.7),
          PatternCurve(two.x, two.down, 0.7, 3.7),
          {alpha_d, beta_d, (v - u) / length, u, beta_a},
          {exact_outer}};
}

std::vector<TaxelBranch> drawn_branches(Numbers& number, const ElamModel& truth, double noise) {
  std::vector<TaxelBranch> branches;
  const double x0 = truth.x0(), xu = truth.xu();
  for (const bool up : {false, true})
    for (int n = 0; n < 4; ++n) {
      const double turn = n == 0 ? (up ? x0 : xu) : x0 + (0.1 + 0.8 * number()) * (xu - x0), end = up ? xu : x0;
      const double start = (up ? truth.descending : truth.ascending)(turn);
      const ElamCurve curve(truth, up, turn, start);
      TaxelBranch& branch = branches.emplace_back(TaxelBranch{up, {turn}, {start}});
      const int samples = 4 + static_cast<int>(8.0 * number());
      for (int i = 1; i <= samples; ++i) {
        const double x = turn + (end - turn) * i / samples;
        branch.pressure_psi.push_back(x);
        branch.volts.push_back(curve.output(x) + noise * (2.0 * number() - 1.0));
      }
    }
  return branches;
}

}  // namespace

TEST_CASE("recorded: ELAM's searches on patterns of many shapes end where they ended when recorded") {
  Summed summed(4 * 15);
  for (int shape = 0; shape < 4; ++shape) {
    Numbers number(static_cast<std::uint64_t>(40 + shape));
    for (int problem = 0; problem < 60; ++problem) {
      const TwoPatterns two = patterns_of_shape(shape);
      const ElamModel truth = drawn_model(number, two, problem % 2 == 1);
      const double noise = problem % 5 == 0 ? 0.0 : problem % 5 == 1 ? 0.02 : 0.6;
      const std::vector<TaxelBranch> branches = drawn_branches(number, truth, noise);
      const ElamFit fit = identify_elam(truth.ascending, truth.descending, branches, truth.options, problem % 3 == 2);
      const ElamParameters& p = fit.model.parameters;
      summed.add(fit.j_v2, fit.mean_error_v, static_cast<int>(fit.undetermined));
      summed.add(p.alpha_d, p.beta_d, static_cast<int>(fit.at_bound));
      summed.add(100.0 * p.alpha_a1, p.alpha_a0, 0);
      summed.add(p.beta_a, fit.max_error_v, 0);
    }
  }
  check_recorded(summed,
                 {{119.7578683, 38.0134656, 3858},
                  {98.8252045, 37.8012303, 8814},
                  {107.9798347, 36.8599951, 4492},
                  {127.0279525, 34.9276815, 6293},
                  {122.7993455, 33.2645663, 5469},
                  {119.0479107, 38.6639731, 6995},
                  {116.1322535, 34.5444134, 6291},
                  {108.1541729, 32.1457453, 7644},
                  {116.8241739, 33.1583036, 2127},
                  {107.8708295, 37.1623659, 6836},
                  {119.8360699, 38.4437870, 2999},
                  {105.3749787, 38.8890582, 7528},
                  {129.4546594, 29.5341391, 4061},
                  {120.6176187, 36.3200270, 5080},
                  {119.2989578, 35.2994539, 6991},
                  {112.1482742, 40.2319615, 3010}},
                 1e-5);
}
