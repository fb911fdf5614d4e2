// The rivals' regressions by hand, on few samples: weights of Preisach's one cell, GPI's unknowns and their errors.
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/rivals/gpi_lanes.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "analysis/identify/rivals/nnls.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/gpi_reference.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

// Over 0 to 10, patterns straight from 0 to `top`.
FitData few_samples(const std::vector<double>& x, const std::vector<double>& y, double top = 6.0) {
  const std::vector<double> ends{0, 10}, outputs{0, top};
  const PatternCurve pattern(ends, outputs, 0.0, top);
  return {{{"few", x, y, branches_along(x), {}, {}}}, pattern, pattern};
}

double one_weight(const FitData& data, bool by_input, const std::vector<std::string>& open) {
  const ModelFit fit = identify("preisach", data, {.cells = 1, .by_input = by_input});
  CHECK(fit.undetermined == open);
  REQUIRE(fit.model->parameters().size() == 1);
  return fit.model->parameters()[0].value;
}

// GPI's normalised data, and a place in its unknowns.
struct GpiProblem {
  FitData data;
  FitSamples samples{data};
  GpiTree tree{samples};
  GpiTree::Target target = tree.target(shares());
  GpiLanes lanes{tree};
  GpiFound start;
  explicit GpiProblem(FitData fitted = paper_both(0.03, 0.02)) : data(std::move(fitted)) {
    start.at = {0.8, 0.1, -0.5, 0.3, -0.1, -0.2, -2.0, 0.3};
    lanes.at.fill(start.at);
    lanes.evaluate(target, true);
    start.j = lanes.j[0];
  }

 private:
  [[nodiscard]] std::vector<double> shares() const {
    std::vector<double> y = samples.outputs(data);
    for (double& value : y) value /= data.ascending.y().back();
    return y;
  }
};

constexpr double kOneRidge = 1.0001;  // external branches alone: the one diagonal is larger by this

}  // namespace

TEST_CASE("Preisach: one cell's weight is the least squares of its shares, with a ridge for external branches") {
  // Shares of a half, 1, a half and 0 at outputs of 2, 6, 5 and 0: 9.5 of 1.5.
  const FitData loop = few_samples({0, 5, 10, 5, 0}, {0, 2, 6, 5, 0});
  CHECK(one_weight(loop, false, {"w"}) == Approx(9.5 / 1.5 / kOneRidge).epsilon(1e-9));
  // Up to 10, down to 5, up again: 6 + 2 + 5 of 2.25, and no ridge, since a branch begins inside.
  const FitData inner = few_samples({0, 10, 5, 10, 0}, {0, 6, 4, 5, 0});
  CHECK(one_weight(inner, false, {}) == Approx(13.0 / 2.25).epsilon(1e-9));
  // Within a hundredth of the ends it does not begin inside.
  CHECK_NOTHROW(one_weight(few_samples({0, 10, 0.0625, 9.9375, 0}, {0, 6, 0, 6, 0}), false, {"w"}));
  CHECK_NOTHROW(one_weight(few_samples({0, 10, 0.125, 10, 0}, {0, 6, 0, 6, 0}), false, {}));
  CHECK_NOTHROW(one_weight(few_samples({0, 9.875, 0, 10, 0}, {0, 6, 0, 6, 0}), false, {}));
  // Outputs that fall have no weight.
  const ModelFit none = identify("preisach", few_samples({0, 5, 10, 5, 0}, {0, -2, -6, -5, 0}), {.cells = 1});
  CHECK(none.model->parameters().empty());
  CHECK(none.max_error == 6.0);
  CHECK(none.mean_error == Approx(13.0 / 4.0));
  CHECK(none.j == Approx(4.0 + 36.0 + 25.0));
  for (const int cells : {0, 101}) CHECK_THROWS_AS(identify("preisach", loop, {.cells = cells}), std::invalid_argument);
  CHECK_NOTHROW(prepare("preisach", loop, {.cells = 100, .by_input = true}));
}

TEST_CASE("Preisach: fitting by input weights a sample by the inverse square of the local slope of its branch") {
  // Slopes 6 / 10 at the second sample, 1 / 5 at the turn (of the way down), 6 / 10 and 1 beyond.
  const double middle = 1.0 / 0.36, turn = 1.0 / 0.04;
  CHECK(one_weight(few_samples({0, 5, 10, 5, 0}, {0, 2, 6, 5, 0}), true, {"w"}) ==
        Approx((middle * (1.0 + 2.5) + turn * 6.0) / (0.5 * middle + turn) / kOneRidge).epsilon(1e-9));
  // A flat turn counts as a tenth of the mean slope of 24 / 40.
  const double flat = 1.0 / 0.0036;
  CHECK(one_weight(few_samples({0, 5, 10, 5, 0}, {0, 2, 6, 6, 0}), true, {"w"}) ==
        Approx((middle * (1.0 + 3.0) + flat * 6.0) / (0.5 * middle + flat) / kOneRidge).epsilon(1e-9));
}

TEST_CASE("GPI: unknowns are limited to their bounds and convert to the model's parameters") {
  GpiVector far;
  far << 100, 2e3, 100, -100, -2e3, -100, 100, 100;
  const GpiPoint high = gpi_within(far), low = gpi_within(-far);
  const std::vector<double> ends{std::log(60.0), 1e3, 10.0, std::log(1e-3), -1e3, -20.0, 4.0, 20.0},
      others{std::log(1e-3), -1e3, -20.0, std::log(60.0), 1e3, 10.0, -10.0, -8.0};
  for (std::size_t k = 0; k < 8; ++k) {
    CAPTURE(k);
    CHECK(high[k] == ends[k]);
    CHECK(low[k] == others[k]);
  }
  GpiVector within;
  within << 1, 2, 3, -1, -2, -3, 0.5, -0.5;
  CHECK(vector_of(gpi_within(within)) == within);
  within[1] = std::nan("");
  CHECK(gpi_within(within)[1] == 0.0);
  // Over 20 psi and 4 V: a rate of ln 2, from a quarter of 4 V up by half of them; e^-ln 2 leaves half.
  GpiPoint p{};
  p[kLnA] = std::log(std::log(2.0));
  p[kL0] = 0.25;
  p[kLnDl] = std::log(0.5);
  p[kLnB] = std::log(std::log(4.0));
  p[kR0] = -0.5;
  p[kLnDr] = std::log(0.75);
  p[kLnAlpha] = std::log(0.125);
  p[kS] = 0.7;
  const GpiParameters found = gpi_parameters(p, 20.0, 4.0);
  CHECK(found.a1 == Approx(std::log(2.0) / 20.0));
  CHECK(found.a0 == Approx(4.0));
  CHECK(found.a3 == Approx(1.0 + 4.0));
  CHECK(found.b1 == Approx(std::log(4.0) / 20.0));
  CHECK(found.b0 == Approx(4.0));
  CHECK(found.b3 == Approx(-2.0 + 4.0));
  CHECK(found.alpha == Approx(0.5));
  CHECK(found.tau == Approx(1.4));
}

TEST_CASE("GPI: standard errors of the unknowns follow from the normal equations and the sample variance") {
  std::mt19937 random(6);
  FitData data = paper_both(0.03, 0.02);
  const std::vector<double> inputs = random_inputs(random, 40, 0.0, 60.0, 3);
  data.histories.push_back(drive("random", inputs, Plant(model_of(paper_loop(), kPrinted, true)), 0.02));
  const GpiProblem problem(data);
  const GpiMatrix inverse = GpiNormal(problem.lanes, 0).matrix.inverse();
  for (const double variance : {1.0, 1e-4}) {
    const GpiPoint errors = GpiSearch(problem.tree, problem.target).errors(problem.start, variance);
    for (int k = 0; k < kGpiUnknowns; ++k) {
      CAPTURE(k);
      CHECK(errors[static_cast<std::size_t>(k)] == Approx(std::sqrt(variance * inverse(k, k))).epsilon(1e-5));
    }
  }
}

TEST_CASE("GPI: the evolution strategy stops at its last generation, or when steps become negligible") {
  GpiProblem problem;
  GpiEvolution small(problem.lanes, problem.target, problem.start, 1e-5);
  small.go(problem.lanes, problem.target, 100);
  CHECK(small.best().at == problem.start.at);
  GpiEvolution once(problem.lanes, problem.target, problem.start, 0.05), twice = once;
  once.go(problem.lanes, problem.target, 6);
  for (const int last : {3, 3, 6}) twice.go(problem.lanes, problem.target, last);
  CHECK(twice.best().at == once.best().at);
  CHECK(once.best().j < problem.start.j);
}

// GPI's tree of states against play operators walked along the data: what is compared at one step has one model value,
// and what a larger swing has wiped out is not told apart.

namespace {

// Play operators of a virgin sensor, and a sum of them in which none hides another.
class Plays {
 public:
  double to(double x) {
    double sum = x;
    for (std::size_t k = 0; k < at_.size(); ++k) {
      const double half = 0.03 + 0.06 * static_cast<double>(k);
      at_[k] = std::clamp(at_[k], x - half, x + half);
      sum += at_[k] / (2.0 + static_cast<double>(k));
    }
    return sum;
  }

 private:
  std::vector<double> at_ = std::vector<double>(9, 0.0);
};

// The inputs as shares of the range, each way from a virgin sensor.
FitData played(const std::vector<std::vector<double>>& ways) {
  const std::vector<double> ends{0.0, 1.0};
  const PatternCurve line(ends, ends, 0.0, 1.0);
  FitData data{{}, line, line};
  for (const std::vector<double>& way : ways) {
    Plays plays;
    data.histories.push_back({"way", way, {}, branches_along(way), {}, {}});
    for (const double x : way) data.histories.back().y.push_back(plays.to(x));
  }
  return data;
}

std::size_t check_tree(const FitData& data) {
  const FitSamples samples(data);
  const GpiTree tree(samples);
  const std::vector<double> y = samples.outputs(data);
  const GpiTree::Target target = tree.target(y);
  CHECK(target.constant < 1e-20);
  double weights = 0.0;
  for (const GpiTree::Step& step : tree.steps) weights += step.weight;
  CHECK(weights == static_cast<double>(samples.fitted.size()));
  // Walked node by node, with no more states kept than there are slots.
  std::vector<Plays> slots(tree.slots);
  for (const GpiTree::Node& node : tree.nodes) {
    Plays here = node.from == GpiTree::kVirgin ? Plays() : slots.at(node.from);
    (void)here.to(tree.knots.at(node.knot));
    slots.at(node.slot) = here;
    for (std::size_t s = node.first; s < node.end; ++s) {
      Plays there = here;
      CHECK(there.to(tree.knots.at(tree.steps[s].knot)) == Approx(target.mean[s]).epsilon(1e-12));
    }
  }
  return tree.steps.size();
}

}  // namespace

TEST_CASE("GPI tree: closed loops and repeats are compared once") {
  // Up, down, up again: three steps, and two more loops between the same turns add none.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}})) == 3);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8, 0.4, 0.8, 0.4}})) == 3);
  // A second history from a virgin sensor shares what it has in common with the first.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}, {0, 0.8, 0.4, 0.8}})) == 3);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}, {0, 0.8, 0.2}})) == 4);
  // Beyond the first turn the inner loop is wiped out: 0.9 is then reached as from below.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.9, 0.4, 0.9}})) == 5);
  // An inner loop of an inner loop, closed at 0.4: the same fall goes on.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.6, 0.4, 0.2, 0.4}})) == 6);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.6, 0.5, 0.6, 0.4, 0.6, 0.5, 0.6}})) == 6);
  // A fall to 0 is no virgin state: the next rise differs from the first.
  CHECK(check_tree(played({{0, 0.8, 0, 0.8, 0, 0.8}})) == 3);
}

TEST_CASE("GPI tree: samples of random inputs are merged only where the play operators have one value") {
  std::mt19937 random(4);
  for (int n = 0; n < 40; ++n) {
    std::uniform_int_distribution<int> twelfth(0, 12), length(3, 40);
    std::vector<std::vector<double>> ways(n % 3 == 0 ? 2 : 1);
    for (std::vector<double>& way : ways) {
      way = {0.0, 0.5, 0.25};
      for (int i = length(random); i-- > 0;) {
        const double next = twelfth(random) / 12.0;
        if (next != way.back()) way.push_back(next);
      }
    }
    CAPTURE(ways);
    CHECK(check_tree(played(ways)) > 0);
  }
}

// GPI's search: its J is the walk's.

namespace {

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

TEST_CASE("GPI tree: J equals that of the model evaluated along the histories, and its gradient is right") {
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

TEST_CASE("GPI: a fit to more samples than the search uses is at least as close to the data as the true model") {
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
