// The rivals' regressions by hand, on few samples: weights of Preisach's one cell, pooled knots of the monotone curve,
// GPI's unknowns and their errors, and which samples are looked at.
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/identify/fit_samples.h"
#include "analysis/identify/identifier.h"
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

TEST_CASE("monotone by hand: inputs within 1/2000 of the span are one knot, knots that do not rise their mean") {
  const FitData data = few_samples({0, 1, 2, 2.004, 6, 6.006, 10}, {0, 1, 3, 5, 2.5, 7, 8});
  const ModelFit fit = identify_monotone(data, {});
  const auto json = fit.model->to_json();
  const auto x = json["x"].get<std::vector<double>>(), y = json["y"].get<std::vector<double>>();
  REQUIRE(x.size() == 5);
  CHECK(x[0] == 0.0);  // the first and last knot lie at the ends
  CHECK(x[1] == Approx(2.002));
  CHECK(x[2] == 6.0);
  CHECK(x[3] == Approx(6.006));
  CHECK(x[4] == 10.0);
  CHECK(y[0] == 1.0);
  CHECK(y[1] == Approx((2.0 * 4.0 + 2.5) / 3.0));
  CHECK(y[2] == Approx((2.0 * 4.0 + 2.5) / 3.0));
  CHECK(y[3] == Approx(7.0));
  CHECK(y[4] == 8.0);
  // Pooled further back: 4, 3 and 2 are 3, and 1 after them all.
  const auto pooled =
      identify_monotone(few_samples({0, 1, 2, 3, 4, 10}, {0, 0.5, 4, 3, 2, 8}), {}).model->to_json()["y"];
  CHECK(pooled[1].get<double>() == Approx(3.0));
  CHECK(pooled[3].get<double>() == Approx(3.0));
  const auto further =
      identify_monotone(few_samples({0, 1, 2, 3, 4, 10}, {0, 0.5, 4, 5, 0, 8}), {}).model->to_json()["y"];
  CHECK(further[1].get<double>() == Approx(3.0));
  CHECK(further[3].get<double>() == Approx(3.0));
  CHECK_THROWS_AS(identify_monotone(few_samples({0, 5, 10}, {0, 3, 3}), {}), std::invalid_argument);
}

TEST_CASE("non-negative least squares by hand: inside, at the bound, and no more columns than are needed") {
  Eigen::MatrixXd gram(2, 2);
  gram << 2, 1, 1, 2;
  const auto solved = [&](double a, double b) {
    const Eigen::VectorXd x = non_negative_least_squares(gram, Eigen::Vector2d(a, b));
    return std::pair{x[0], x[1]};
  };
  const auto check = [&](double a, double b, double x, double y) {
    CAPTURE(a, b);
    const auto found = solved(a, b);
    CHECK(found.first == Approx(x));
    CHECK(found.second == Approx(y));
  };
  check(3, 3, 1, 1);
  check(5, 4, 2, 1);
  check(4, 1, 2, 0);  // alone: the other's gradient is 1 - 2
  check(-1, 3, 0, 1.5);
  check(-1, -2, 0, 0);
  // Of columns (1, 0), (0, 1) and (8, 6) the last enters first; with the first it gives (1, 0.1), and needs no third.
  Eigen::MatrixXd three(3, 3);
  three << 1, 0, 8, 0, 1, 6, 8, 6, 100;
  const Eigen::VectorXd x = non_negative_least_squares(three, Eigen::Vector3d(1.0, 0.1, 8.6));
  CHECK(x[0] == Approx(1.0 - 0.1 * 8.0 / 6.0));
  CHECK(x[1] == 0.0);
  CHECK(x[2] == Approx(0.1 / 6.0));
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
  const FitSamples samples(data);
  const GpiTree tree(samples);
  std::vector<double> share = samples.outputs(data);
  for (double& y : share) y /= 3.49;
  const GpiTree::Target target = tree.target(share);
  GpiFound at;
  at.at = {0.8, 0.1, -0.5, 0.3, -0.1, -0.2, -2.0, 0.3};
  GpiLanes lanes(tree);
  lanes.at.fill(at.at);
  lanes.evaluate(target, true);
  const GpiMatrix inverse = GpiNormal(lanes, 0).matrix.inverse();
  for (const double variance : {1.0, 1e-4}) {
    const GpiPoint errors = GpiSearch(tree, target).errors(at, variance);
    for (int k = 0; k < kGpiUnknowns; ++k) {
      CAPTURE(k);
      CHECK(errors[static_cast<std::size_t>(k)] == Approx(std::sqrt(variance * inverse(k, k))).epsilon(1e-5));
    }
  }
}

TEST_CASE("samples of a fit: all of a branch but its first, inputs brought into the loop, recordings that come down") {
  FitData data = few_samples({-1, 5, 11, 4, 0}, {0, 3, 6, 3, 0});
  data.histories.push_back({"late", {8, 3, 9}, {5, 2, 6}, branches_along(std::vector<double>{8, 3, 9}), {}, {}});
  const FitSamples samples(data);
  CHECK(samples.x_low == 0.0);
  CHECK(samples.x_high == 10.0);
  CHECK(samples.x == std::vector<double>{0, 5, 10, 4, 0, 8, 3, 9});
  CHECK(samples.scored == std::vector<std::size_t>{1, 2, 3, 4, 6, 7});
  CHECK(samples.fitted == samples.scored);
  REQUIRE(samples.parts.size() == 4);
  CHECK((samples.parts[0].opens_history && !samples.parts[0].from_top && samples.parts[0].ascending));
  CHECK((!samples.parts[1].opens_history && !samples.parts[1].from_top));
  CHECK((samples.parts[2].opens_history && samples.parts[2].from_top));
  CHECK((samples.parts[2].first == 5 && samples.parts[2].last == 6));
  CHECK((!samples.parts[3].from_top && samples.parts[3].first == 6 && samples.parts[3].last == 7));
  CHECK(samples.outputs(data) == std::vector<double>{0, 3, 6, 3, 0, 5, 2, 6});
  FitData other = data;
  other.histories[1].branches[1].last = 1;
  CHECK_THROWS_AS(samples.outputs(other), std::invalid_argument);
  // Branches follow each other, within the history, with two samples or more.
  const auto taken = [&](const std::vector<Branch>& branches) {
    FitData own = data;
    own.histories[0].branches = branches;
    try {
      const FitSamples all(own);
      return all.parts.size();
    } catch (const std::invalid_argument&) {
      return std::size_t{0};
    }
  };
  CHECK(taken({{0, 2, true}, {2, 4, false}}) == 4);
  CHECK(taken({{0, 2, true}, {3, 4, false}}) == 4);
  CHECK(taken({{0, 2, true}, {1, 4, false}}) == 0);
  CHECK(taken({{0, 2, true}, {2, 5, false}}) == 0);
  CHECK(taken({{0, 2, true}, {2, 2, false}}) == 0);
  CHECK(taken({{-1, 2, true}, {2, 4, false}}) == 0);
}
