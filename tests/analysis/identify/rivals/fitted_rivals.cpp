// The rivals' regressions by hand, on few samples: weights of Preisach's one cell, GPI's unknowns and their errors.
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/identify/fit_samples.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/gpi_evolution.h"
#include "analysis/identify/rivals/gpi_normal.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "analysis/identify/rivals/nnls.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// Over 0 to 10, patterns straight from 0 to `top`.
FitData few_samples(const std::vector<double>& x, const std::vector<double>& y, double top = 6.0) {
  const std::vector<double> ends{0, 10}, outputs{0, top};
  const PatternCurve pattern(ends, outputs, 0.0, top);
  return {{{"few", x, y, branches_along(x), {}, {}}}, pattern, pattern};
}

double one_weight(const FitData& data, bool by_input, const std::vector<std::string>& open) {
  IdentifyOptions options;
  options.cells = 1;
  options.by_input = by_input;
  const ModelFit fit = identify_preisach(data, options);
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

TEST_CASE(
    "Preisach by hand: one cell's weight is the least squares' of its shares, with a ridge on external branches") {
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
  const ModelFit none = identify_preisach(few_samples({0, 5, 10, 5, 0}, {0, -2, -6, -5, 0}), {.cells = 1});
  CHECK(none.model->parameters().empty());
  CHECK(none.max_error == 6.0);
  CHECK(none.mean_error == Approx(13.0 / 4.0));
  CHECK(none.j == Approx(4.0 + 36.0 + 25.0));
  for (const int cells : {0, 101}) CHECK_THROWS_AS(identify_preisach(loop, {.cells = cells}), std::invalid_argument);
  CHECK_NOTHROW(prepare("preisach", loop, {.cells = 100, .by_input = true}));
}

TEST_CASE("Preisach by hand: by inputs a sample counts with the square of the inverse slope about it on its branch") {
  // Slopes 6 / 10 at the second sample, 1 / 5 at the turn (of the way down), 6 / 10 and 1 beyond.
  const double middle = 1.0 / 0.36, turn = 1.0 / 0.04;
  CHECK(one_weight(few_samples({0, 5, 10, 5, 0}, {0, 2, 6, 5, 0}), true, {"w"}) ==
        Approx((middle * (1.0 + 2.5) + turn * 6.0) / (0.5 * middle + turn) / kOneRidge).epsilon(1e-9));
  // A flat turn counts as a tenth of the mean slope of 24 / 40.
  const double flat = 1.0 / 0.0036;
  CHECK(one_weight(few_samples({0, 5, 10, 5, 0}, {0, 2, 6, 6, 0}), true, {"w"}) ==
        Approx((middle * (1.0 + 3.0) + flat * 6.0) / (0.5 * middle + flat) / kOneRidge).epsilon(1e-9));
}

TEST_CASE("non-negative least squares by hand: of columns in small and large units as of others") {
  for (const double unit : {1e-7, 1e-3, 1e3, 1e7}) {
    CAPTURE(unit);
    Eigen::MatrixXd gram(2, 2);
    gram << 2, 1, 1, 2;
    gram *= unit;
    const Eigen::VectorXd x = non_negative_least_squares(gram, Eigen::Vector2d(5.0 * unit, 4.0 * unit));
    CHECK(x[0] == Approx(2.0));
    CHECK(x[1] == Approx(1.0));
  }
}

TEST_CASE("GPI by hand: unknowns within their bounds, and the parameters that they stand for") {
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

TEST_CASE("GPI: the errors of its unknowns are those of the normal equations, by the variance of a sample") {
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

TEST_CASE("GPI: its evolution strategy ends at its last generation, or when steps no longer matter") {
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
