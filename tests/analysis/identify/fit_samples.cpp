// What every identification is given, by hand: parts, scored samples, refusals; figures of a fit.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/fit_samples.h"

using namespace tactbench::analysis;

namespace {

FitData up_and_down() {
  const std::vector<double> x{0.0, 30.0, 60.0}, up{0.0, 1.0, 3.0}, down{0.0, 2.0, 3.0};
  FitData data;
  data.ascending = PatternCurve(x, up, 0.0, 3.0);
  data.descending = PatternCurve(x, down, 0.0, 3.0);
  data.histories = {{"loop", {-1.0, 30.0, 61.0, 30.0, 0.0}, {0.0, 1.0, 3.0, 2.0, 0.0}, {{0, 2, true}, {2, 4, false}}},
                    {"back", {60.0, 40.0, 20.0}, {3.0, 2.4, 1.5}, {{0, 2, false}}}};
  return data;
}

std::string samples_refused(const FitData& data, bool one_way = false) {
  return why_invalid([&] { return FitSamples(data, one_way); });
}

}  // namespace

TEST_CASE("FitSamples: clips inputs to the loop, marks the start of each branch, and scores all but first samples") {
  const FitSamples samples(up_and_down());
  CHECK((samples.x_low == 0.0 && samples.x_high == 60.0));
  CHECK(samples.x == std::vector<double>{0.0, 30.0, 60.0, 30.0, 0.0, 60.0, 40.0, 20.0});
  REQUIRE(samples.parts.size() == 3);
  const auto part = [&](std::size_t i) {
    const FitSamples::Part& own = samples.parts[i];
    return std::vector<std::size_t>{own.ascending ? 1U : 0U, own.opens_history ? 1U : 0U, own.from_top ? 1U : 0U,
                                    own.first, own.last};
  };
  CHECK(part(0) == std::vector<std::size_t>{1, 1, 0, 0, 2});
  CHECK(part(1) == std::vector<std::size_t>{0, 0, 0, 2, 4});
  CHECK(part(2) == std::vector<std::size_t>{0, 1, 1, 5, 7});
  CHECK(samples.scored == std::vector<std::size_t>{1, 2, 3, 4, 6, 7});
  CHECK(samples.fitted == samples.scored);
  CHECK(samples.outputs(up_and_down()) == std::vector<double>{0.0, 1.0, 3.0, 2.0, 0.0, 3.0, 2.4, 1.5});
}

TEST_CASE("FitSamples: data that cannot be fitted are refused with a reason") {
  CHECK(samples_refused(up_and_down()).empty());
  const auto spoilt = [](const auto& change) {
    FitData data = up_and_down();
    change(data);
    return samples_refused(data);
  };
  const double none = std::numeric_limits<double>::quiet_NaN(), endless = std::numeric_limits<double>::infinity();
  for (const double bad : {none, endless, -endless}) {
    CHECK_THAT(spoilt([&](FitData& d) { d.histories[0].x[3] = bad; }), Catch::Contains("\"loop\""));
    CHECK_THAT(spoilt([&](FitData& d) { d.histories[1].y[2] = bad; }), Catch::Contains("\"back\""));
  }
  CHECK(spoilt([&](FitData& d) { d.histories[1].y[2] = std::numeric_limits<double>::max(); }).empty());
  CHECK_FALSE(spoilt([](FitData& d) { d.histories[0].y.pop_back(); }).empty());
  for (const auto& [first, last] : {std::pair{1, 4}, {3, 3}, {4, 2}, {2, 5}}) {
    INFO(first << " to " << last);
    CHECK_THAT(spoilt([&, from = first, to = last](FitData& d) {
                 d.histories[0].branches[1] = {from, to, false};
               }),
               Catch::Contains("\"loop\""));
  }
  CHECK(spoilt([](FitData& d) { d.histories[0].branches[1] = {3, 4, false}; }).empty());  // samples between two
  CHECK_FALSE(spoilt([](FitData& d) { d.ascending = {}; }).empty());
  CHECK_FALSE(spoilt([](FitData& d) { d.descending = {}; }).empty());
  const std::vector<double> x{0.0, 60.0}, y{0.0, 3.0};
  const auto other_curve = [&](std::vector<double> at, std::vector<double> out) {
    return spoilt([&](FitData& d) { d.descending = PatternCurve(at, out, out.front(), out.back()); });
  };
  CHECK(other_curve(x, y).empty());
  for (const auto& [at, out] : {std::pair{std::vector{1.0, 60.0}, y},
                                {std::vector{0.0, 59.0}, y},
                                {x, std::vector{0.1, 3.0}},
                                {x, std::vector{0.0, 2.9}}})
    CHECK_FALSE(other_curve(at, out).empty());
}

TEST_CASE("FitSamples: needs both directions, or one if that is enough") {
  FitData data = up_and_down();
  const History falls = data.histories[1], rises{"up", {0.0, 30.0}, {0.0, 1.0}, {{0, 1, true}}};
  for (const History& one : {falls, rises}) {
    data.histories = {one};
    CHECK_FALSE(samples_refused(data).empty());
    CHECK(samples_refused(data, true).empty());
  }
  data.histories[0].branches.clear();
  CHECK_FALSE(samples_refused(data, true).empty());
}

TEST_CASE("FitSamples: outputs are accepted only for the same inputs and branches") {
  const FitSamples samples(up_and_down());
  const auto refused = [&](const auto& change) {
    FitData data = up_and_down();
    change(data);
    return why_invalid([&] { (void)samples.outputs(data); });
  };
  CHECK(refused([](FitData& d) { d.histories[0].y[1] = 7.0; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories.pop_back(); }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].x[2] = 20.5; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].x.push_back(10.0); }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[0].branches[0].last = 1; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[0].branches[1].first = 3; }).empty());
  CHECK_FALSE(refused([](FitData& d) { d.histories[1].branches[0].ascending = true; }).empty());
  const std::vector<double> wider{0.0, 30.0, 61.0}, lower{-1.0, 30.0, 60.0}, y{0.0, 1.0, 3.0};
  for (const std::vector<double>& x : {wider, lower})
    CHECK_FALSE(refused([&](FitData& d) {
                  d.ascending = PatternCurve(x, y, 0.0, 3.0);
                  d.descending = d.ascending;
                }).empty());
  const auto missing = Catch::Contains("\"back\"");
  CHECK_THAT(refused([](FitData& d) { d.histories[1].y.pop_back(); }), missing);
  CHECK_THAT(refused([](FitData& d) { d.histories[1].y[0] = std::numeric_limits<double>::quiet_NaN(); }), missing);
}

TEST_CASE("fit errors: sum of squares, mean and largest error are right for any number of samples") {
  const FitData data = up_and_down();
  const std::vector<double> errors = {0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7, -0.8, 0.9};
  for (std::size_t n = 1; n <= errors.size(); ++n) {
    INFO(n);
    ModelFit fit;
    score(fit, data, std::span(errors).first(n));
    const auto count = static_cast<double>(n);
    CHECK(fit.j == Approx(0.01 * count * (count + 1.0) * (2.0 * count + 1.0) / 6.0));
    CHECK(fit.mean_error == Approx(0.1 * (count + 1.0) / 2.0));
    CHECK(fit.max_error == Approx(0.1 * count));
    CHECK((fit.samples == static_cast<int>(n) && fit.full_scale == 3.0));
  }
}

// Least squares without negative values, and single-valued curves by the means of neighbours: by hand.

namespace {

// Of columns with these products among themselves and with the right side.
std::vector<double> least_squares(const std::vector<std::vector<double>>& gram, const std::vector<double>& along) {
  const auto n = static_cast<Eigen::Index>(along.size());
  Eigen::MatrixXd a(n, n);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    b[i] = along[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < n; ++j) a(i, j) = gram[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  const Eigen::VectorXd x = non_negative_least_squares(a, b);
  return {x.begin(), x.end()};
}

FitData single_way(const std::vector<double>& x, const std::vector<double>& y) {
  FitData data;
  const std::vector<double> ends{0, 10}, outputs{0, 6};
  data.ascending = data.descending = PatternCurve(ends, outputs, 0.0, 6.0);
  data.histories = {History{"h", x, y, {{0, static_cast<int>(x.size()) - 1, true}}, {}, {}}};
  return data;
}

double curve_at(const ModelFit& fit, double x) {
  const auto state = fit.model->state();
  state->go(x);
  return state->output_at(x);
}

}  // namespace

TEST_CASE("non-negative least squares: negative coefficients become 0 and the others are fitted again") {
  check_alike(least_squares({{2, 0}, {0, 4}}, {3, 8}), {1.5, 2}, 1e-12);
  check_alike(least_squares({{1, 0}, {0, 1}}, {1, -2}), {1, 0}, 1e-12);
  check_alike(least_squares({{2, 1}, {1, 2}}, {1, -1}), {0.5, 0}, 1e-12);  // without bounds 1 and -1
  check_alike(least_squares({{2, 1}, {1, 2}}, {3, 3}), {1, 1}, 1e-12);
  check_alike(least_squares({{4, 2}, {2, 2}}, {4, 1}), {1, 0}, 1e-12);  // without bounds 1.5 and -1
  check_alike(least_squares({{1, 0}, {0, 1}}, {-1, -2}), {0, 0}, 1e-12);
  check_alike(least_squares({{1, 0}, {0, 1}}, {0, 0}), {0, 0}, 1e-12);
  // The first taken (along 5) has to leave again: columns (1, 1), (1, 0), (0, 1) of the right side (2, 3).
  check_alike(least_squares({{2, 1, 1}, {1, 1, 0}, {1, 0, 1}}, {5, 2, 3}), {2, 0, 1}, 1e-12);
  // Two equal columns: one of them has it all.
  const std::vector<double> twins = least_squares({{1, 1}, {1, 1}}, {2, 2});
  CHECK(twins[0] + twins[1] == Approx(2.0));
  CHECK(std::min(twins[0], twins[1]) == 0.0);
  // Whatever the unit of the columns.
  for (const double unit : {1e-7, 1e-3, 1e3, 1e7})
    check_alike(least_squares({{2 * unit, unit}, {unit, 2 * unit}}, {5 * unit, 4 * unit}), {2, 1});
}

TEST_CASE("non-negative least squares: no subset of columns gives a smaller sum of squares") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  constexpr int kColumns = 5;
  for (int problem = 0; problem < 60; ++problem) {
    Eigen::MatrixXd a(7, kColumns);
    Eigen::VectorXd y(7);
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      y[i] = normal(random) + 0.3;
      for (Eigen::Index j = 0; j < kColumns; ++j) a(i, j) = normal(random) + (problem % 3 == 0 ? 1.0 : 0.0);
    }
    // Of each of 32 sets the plain least squares, where none of it is negative.
    double least = y.squaredNorm();
    for (unsigned set = 1; set < 1U << kColumns; ++set) {
      std::vector<int> columns;
      for (int j = 0; j < kColumns; ++j)
        if ((set >> j & 1U) != 0) columns.push_back(j);
      const Eigen::MatrixXd own = a(Eigen::all, columns);
      const Eigen::VectorXd x = own.colPivHouseholderQr().solve(y);
      if (x.minCoeff() >= 0.0) least = std::min(least, (own * x - y).squaredNorm());
    }
    const Eigen::VectorXd found = non_negative_least_squares(a.transpose() * a, a.transpose() * y);
    INFO("problem " << problem);
    CHECK(found.minCoeff() >= 0.0);
    CHECK((a * found - y).squaredNorm() == Approx(least).epsilon(1e-9));
  }
}

TEST_CASE("monotone model: near inputs share a knot, and falling outputs become their weighted mean") {
  // Within a two-thousandth of the span, 0.005, of a knot's begin: 5 and 5.004 are one, of 4 V. Then 2 V at 8: with it
  // (4 + 4 + 2) / 3. The first sample of a branch does not count; the curve's ends are those of the loop.
  const ModelFit one = identify("monotone", single_way({0, 2, 5, 5.004, 8, 10}, {9, 1, 3, 5, 2, 6}));
  CHECK(one.samples == 5);
  CHECK(one.full_scale == 6.0);
  CHECK(curve_at(one, 0.0) == Approx(1.0));
  CHECK(curve_at(one, 2.501) == Approx((1.0 + 10.0 / 3.0) / 2));
  CHECK(curve_at(one, 5.002) == Approx(10.0 / 3.0));
  CHECK(curve_at(one, 7.0) == Approx(10.0 / 3.0));
  CHECK(curve_at(one, 9.0) == Approx((10.0 / 3.0 + 6.0) / 2));
  CHECK(curve_at(one, 10.0) == Approx(6.0));
  // The errors are those of the walk: at 2 the curve reads 1 + 7/3 x 2 / 5.002, at 5, 5.004 and 8 10/3.
  const double at_two = 7.0 / 3.0 * 2.0 / 5.002, at_five = 7.0 / 3.0 * 5.0 / 5.002 + 1.0 - 3.0;
  CHECK(one.j == Approx(at_two * at_two + at_five * at_five + 25.0 / 9.0 + 16.0 / 9.0));
  CHECK(one.mean_error == Approx((at_two + at_five + 5.0 / 3.0 + 4.0 / 3.0) / 5));
  CHECK(one.max_error == Approx(5.0 / 3.0));
  // 5 and 5.006 are two: 3 stays, 5 and 2 are 3.5.
  const ModelFit two = identify("monotone", single_way({0, 2, 5, 5.006, 8, 10}, {9, 1, 3, 5, 2, 6}));
  CHECK(curve_at(two, 5.0) == Approx(3.0));
  CHECK(curve_at(two, 7.0) == Approx(3.5));
  CHECK_THROWS_AS(identify("monotone", single_way({0, 2, 8, 10}, {9, 5, 4, 3})), std::invalid_argument);
}
