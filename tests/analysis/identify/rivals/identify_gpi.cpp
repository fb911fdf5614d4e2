// GPI's search: its J is the walk's, the same on all vectors.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "tests/analysis/identify/rivals/gpi_walked.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

struct Unforced {
  ~Unforced() { unforce_lane_dispatch(); }
};

double walked_share_of(const GpiPoint& point, const FitData& data) {
  const double x_span = data.ascending.x().back() - data.ascending.x().front();
  const double y_span = data.ascending.y().back() - data.ascending.y().front();
  return walked_j(gpi_parameters(point, x_span, y_span), data) / (y_span * y_span);
}

std::vector<double> shares_of(const FitSamples& samples, const FitData& data) {
  std::vector<double> y = samples.outputs(data);
  const double y_low = data.ascending.y().front(), y_span = data.ascending.y().back() - y_low;
  for (double& value : y) value = (value - y_low) / y_span;
  return y;
}

}  // namespace

TEST_CASE("GPI: J along the tree of states is that of the model walked along the histories, slopes are its own") {
  std::mt19937 random(4);
  FitData data = paper_both(0.03, 0.02);
  const std::vector<double> inputs = random_inputs(random, 60, 0.0, 60.0, 3);
  data.histories.push_back(drive("random", inputs, Plant(model_of(paper_loop(), kPrinted, true)), 0.02));
  // A recording that begins on a fall, and one whose inner branch is not among those that are looked at.
  data.histories.push_back(drive("fall", levels_of({40, 10, 30, 0}), [](double x) { return 0.05 * x; }));
  data.histories.push_back(drive("gap", levels_of({0, 50, 20, 40, 10, 60}), [](double x) { return 0.06 * x; }));
  data.histories.back().branches.erase(data.histories.back().branches.begin() + 2);
  const FitSamples samples(data);
  const GpiTree tree(samples);
  CHECK(tree.steps.size() < samples.fitted.size());
  const GpiTree::Target target = tree.target(shares_of(samples, data));
  GpiLanes lanes(tree);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int n = 0; n < 10; ++n) {
    for (GpiPoint& point : lanes.at) {
      point = {unit(random), 0.3 * unit(random),        unit(random), unit(random), -0.5 + 0.5 * unit(random),
               unit(random), -2.0 + 2.0 * unit(random), unit(random)};
    }
    lanes.evaluate(target, true);
    for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane)
      CHECK(lanes.j[lane] == Approx(walked_share_of(lanes.at[lane], data)).epsilon(1e-9));
    // Half of J's gradient, but for the kinks.
    const GpiPoint point = lanes.at[0];
    GpiPoint slope{};
    for (std::size_t k = 0; k < slope.size(); ++k) slope[k] = lanes.slope[k][0];
    for (std::size_t k = 0; k < slope.size(); ++k) {
      lanes.at[0] = lanes.at[1] = point;
      lanes.at[0][k] += 1e-6;
      lanes.at[1][k] -= 1e-6;
      lanes.evaluate(target, false);
      CHECK(2.0 * slope[k] == Approx((lanes.j[0] - lanes.j[1]) / 2e-6).epsilon(1e-3).margin(1e-3 * lanes.j[0]));
    }
  }
}

TEST_CASE("GPI: the fit has the same bits on every vector level") {
  const Unforced unforced;
  const FitData data = paper_data(kDescendingTurns, 0.03);
  force_lane_dispatch(Dispatch::kBase);
  const double j = identify("gpi", data, {.starts = 1}).j;
  for (const Dispatch dispatch : dispatches()) {
    force_lane_dispatch(dispatch);
    CHECK(identify("gpi", data, {.starts = 1}).j == j);
  }
}

TEST_CASE("GPI: of more samples than the search looks at the fit is at least as near to all as the truth is") {
  const GpiModel truth(kGpiTable2, 0.0, 60.0, 0.0);
  std::mt19937 random(4);
  const std::vector<double> inputs = random_inputs(random, 60, 0.0, 60.0, 50), ends{0.0, 60.0};
  const auto at = [&, state = std::shared_ptr<ModelState>(truth.state())](double x) {
    state->go(x);
    return state->output_at(x);
  };
  const History clean = drive("random", inputs, at);
  FitData data;
  const std::vector<double> y{truth.state()->output_at(0.0), truth.state()->output_at(60.0)};
  data.ascending = data.descending = PatternCurve(ends, y, y[0], y[1]);
  data.histories = {clean};
  std::normal_distribution<double> noise(0.0, 0.05);
  for (double& output : data.histories.front().y) output += noise(random);
  double j = 0.0;
  for (std::size_t i = 1; i < inputs.size(); ++i) j += std::pow(data.histories.front().y[i] - clean.y[i], 2);
  CHECK(identify("gpi", data, {.starts = 2}).j < j);
}
