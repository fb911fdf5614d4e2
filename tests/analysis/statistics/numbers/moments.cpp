// Means, deviations, quantiles and lines against answers by hand; where two ways of adding up round otherwise, both.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "analysis/statistics/numbers/moments.h"

using namespace tactbench::analysis;

namespace {

using Doubles = std::vector<double>;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("moments: means of all and of selected values match hand-computed values, without values they are NaN") {
  CHECK(mean_of(Doubles{1.0, 2.0, 6.0}) == 3.0);
  CHECK(mean_of(Doubles{0.1, 0.2, 0.3}) == 0.20000000000000004);
  CHECK(std::isnan(mean_of(Doubles{})));
  const Doubles frame{1.0, 10.0, 100.0, 1000.0};
  const std::vector<int> chosen{3, 1};
  const std::vector<std::size_t> none;
  CHECK(mean_of_chosen(std::span<const double>(frame), std::span<const int>(chosen)) == 505.0);
  CHECK(std::isnan(mean_of_chosen(std::span<const double>(frame), std::span<const std::size_t>(none))));
  CHECK(finite_of(Doubles{kNan, 2.0, kInfinite, 1.0, -kInfinite}) == Doubles{2.0, 1.0});
}

TEST_CASE("moments: deviations about the mean and about a given value match hand-computed values") {
  const Doubles values{2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0};  // mean 5, squares 32
  CHECK(sum_of_squares_about(values, 5.0) == 32.0);
  CHECK(sum_of_squares_about(values, 1.0) == 32.0 + 8.0 * 16.0);
  CHECK(sample_variance(values) == 32.0 / 7.0);
  CHECK(sample_deviation(values) == std::sqrt(32.0 / 7.0));
  CHECK(sample_deviation(Doubles{3.0, 3.0}) == 0.0);
  CHECK(std::isnan(sample_deviation(Doubles{3.0})));
  CHECK(std::isnan(sample_variance(Doubles{})));
}

TEST_CASE("moments: medians and quantiles are one of the values, or lie between two") {
  CHECK(median_of({9.0, 1.0, 5.0}) == 5.0);
  CHECK(median_of({9.0, 1.0, 5.0, 2.0}) == 3.5);
  CHECK(median_of({kNan, 4.0, kInfinite}) == 4.0);
  CHECK(std::isnan(median_of({kNan})));
  const Doubles ten{9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0};
  CHECK(quantile_of(ten, 0.0) == 0.0);
  CHECK(quantile_of(ten, 0.25) == 2.0);
  CHECK(quantile_of(ten, 0.5) == 5.0);
  CHECK(quantile_of(ten, 0.9) == 9.0);
  CHECK(quantile_of(ten, 1.0) == 9.0);
  CHECK(quantile_of({7.0}, 0.5) == 7.0);
  const Doubles sorted{0.0, 10.0, 20.0, 40.0};
  CHECK(quantile_between(sorted, 0.0) == 0.0);
  CHECK(quantile_between(sorted, 0.5) == 15.0);
  CHECK(quantile_between(sorted, 0.75) == 25.0);
  CHECK(quantile_between(sorted, 1.0) == 40.0);
  CHECK(quantile_between(Doubles{7.0}, 0.9) == 7.0);
}

TEST_CASE("moments: a value lies between two rising ones, on one of them, or at the end beyond which it is") {
  struct Row {
    double at;
    std::size_t low, high;
    double share;
  };
  for (const Row& row : {Row{0.5, 0, 0, 0.0},
                         {1.0, 0, 0, 0.0},
                         {1.5, 0, 1, 0.5},
                         {2.0, 1, 1, 0.0},
                         {5.0, 1, 2, 0.75},
                         {6.0, 2, 2, 0.0},
                         {7.0, 2, 2, 0.0},
                         {kNan, 0, 0, 0.0}}) {
    CAPTURE(row.at);
    const Between place = place_among(Doubles{1.0, 2.0, 6.0}, row.at);
    CHECK(place.low == row.low);
    CHECK(place.high == row.high);
    CHECK(place.share == row.share);
  }
}

TEST_CASE("moments: scatter within and between groups of unequal size matches hand-computed values") {
  // Means 2, 5 and 9 of 2, 3 and 1 values, 28/6 of all: within 2 + 2 of 3 degrees of freedom.
  const std::vector<Doubles> groups{{1.0, 3.0}, {}, {4.0, 5.0, 6.0}, {9.0}};
  const GroupedScatter scatter = grouped_scatter(groups);
  CHECK(scatter.groups == 3.0);
  CHECK(scatter.readings == 6.0);
  CHECK(scatter.within_dof == 3.0);
  CHECK(scatter.within == Approx(4.0 / 3));
  const double all = 28.0 / 6, squares = 2 * std::pow(2 - all, 2) + 3 * std::pow(5 - all, 2) + std::pow(9 - all, 2);
  CHECK(scatter.between == Approx((squares / 2 - 4.0 / 3) / ((6 - 14.0 / 6) / 2)));
  CHECK(grouped_scatter(std::vector<Doubles>{{1.0, 2.0}}).between == 0.0);
  CHECK(grouped_scatter(std::vector<Doubles>{{1.0}, {1.0}}).within == 0.0);
}

TEST_CASE("moments: least-squares line, its residual and the correlation match hand-computed values") {
  const Doubles x{0.0, 1.0, 2.0, 3.0, 4.0}, y{1.0, 3.0, 5.0, 7.0, 9.0};
  const LineFit line = line_fit(x, y);
  CHECK(line.slope() == Approx(2.0));
  CHECK(line.at_zero() == Approx(1.0));
  CHECK(line.correlation() == Approx(1.0));
  CHECK(residual_sum_of_squares(line, x, y) == Approx(0.0).margin(1e-20));
  // (0, 0), (1, 3), (2, 0): mean 1, level; it leaves 1 + 4 + 1.
  const LineFit level = line_fit(Doubles{0.0, 1.0, 2.0}, Doubles{0.0, 3.0, 0.0});
  CHECK(level.slope() == 0.0);
  CHECK(level.at_zero() == 1.0);
  CHECK(level.correlation() == 0.0);
  CHECK(residual_sum_of_squares(level, Doubles{0.0, 1.0, 2.0}, Doubles{0.0, 3.0, 0.0}) == 6.0);
  CHECK(line_fit(x, Doubles{9.0, 7.0, 5.0, 3.0, 1.0}).correlation() == Approx(-1.0));
  const LineFit upright = line_fit(Doubles{2.0, 2.0}, Doubles{0.0, 1.0});
  CHECK(upright.correlation() == 0.0);
  CHECK(std::isnan(upright.slope()));
}

// Pooled scatter and its degrees of freedom, against cases on paper.

TEST_CASE("pooled scatter: fully correlated parts have n - 1 degrees of freedom") {
  const std::vector<std::vector<double>> rows = {{1.0, 11.0, 21.0}, {3.0, 13.0, 23.0}};
  const PooledScatter scatter = pooled_scatter(rows);
  CHECK(scatter.s == Approx(std::sqrt(2.0)));
  CHECK(scatter.dof == Approx(1.0));
  CHECK(scatter.parts == 3);
}

TEST_CASE("pooled scatter: parts that cancel in the mean add up their degrees of freedom") {
  // Each part has the variance 2, their mean stands still: (n - 1)(parts - 1) = 3.
  const std::vector<std::vector<double>> rows = {{1.0, 2.0, 5.0, 8.0}, {3.0, 0.0, 7.0, 6.0}};
  const PooledScatter scatter = pooled_scatter(rows);
  CHECK(scatter.s == Approx(std::sqrt(2.0)));
  CHECK(scatter.dof == Approx(3.0));
}

TEST_CASE("pooled scatter: a non-finite part is left out, and one row or no part gives no result") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> rows = {{1.0, none, 2.0}, {2.0, 9.0, 2.0}, {3.0, 9.0, 2.0}};
  const PooledScatter scatter = pooled_scatter(rows);
  REQUIRE(scatter.known());
  CHECK(scatter.parts == 2);
  CHECK(scatter.s == Approx(std::sqrt(0.5)));
  CHECK_FALSE(pooled_scatter(std::vector<std::vector<double>>{{1.0, 2.0}}).known());
  CHECK_FALSE(pooled_scatter(std::vector<std::vector<double>>{{none}, {none}}).known());
  CHECK_FALSE(pooled_scatter({}).known());
  const PooledScatter still = pooled_scatter(std::vector<std::vector<double>>{{1.0, 2.0}, {1.0, 2.0}});
  CHECK(still.s == 0.0);
  CHECK(still.dof == 1.0);
}

// The noise of differences, few samples by hand: which order counts, of how many differences.

namespace {

using Samples = std::vector<double>;

// A difference of unit norm is as large as the noise; the median of a normal one is 0.67449 of it.
double as_noise(double difference) { return difference / 0.67449; }

double noise_of(const Samples& y) { return difference_noise(std::vector<Stretch>{{{}, y}}); }
double placed_noise(const Samples& x, const Samples& y) { return difference_noise(std::vector<Stretch>{{x, y}}); }

Samples ramp(std::size_t count) {
  Samples y;
  for (std::size_t i = 0; i < count; ++i) y.push_back(static_cast<double>(i));
  return y;
}

}  // namespace

TEST_CASE("difference noise: of two to five samples matches hand-computed values, and is 0 for fewer") {
  CHECK(noise_of({5.0, 6.0}) == Approx(as_noise(1.0 / std::sqrt(2.0))));
  CHECK(noise_of({0.0, 1.0, 2.0}) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // the second order is one difference
  // First differences 4, -1, 6, -6; second -5, 7, -12: of sqrt 6 the middle one 7; first of sqrt 2 the upper middle 6.
  // Third 12, -19 over sqrt 20: the larger, 4.25.
  CHECK(noise_of({0.0, 4.0, 3.0, 9.0, 3.0}) == Approx(as_noise(7.0 / std::sqrt(6.0))));
  CHECK(noise_of({}) == 0.0);
  CHECK(noise_of({3.0}) == 0.0);
}

TEST_CASE("difference noise: an order counts from twenty differences on, or from two if no order has twenty") {
  CHECK(noise_of(ramp(4)) == Approx(0.0).margin(1e-12));  // two of the second order
  CHECK(noise_of(ramp(20)) == Approx(0.0).margin(1e-12));
  CHECK(noise_of(ramp(21)) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // twenty of the first, nineteen of the second
  CHECK(noise_of(ramp(22)) == Approx(0.0).margin(1e-12));
}

TEST_CASE("difference noise: the smallest of the orders up to the sixth counts") {
  // 1 -1 1 -1 ...: the difference of order k is the sum of its weights' sizes, 2^k over the root of the sum of squares,
  // C(2k, k): 1.41, 1.63, 1.79, 1.91, 2.02, 2.11. The first is least.
  Samples y;
  for (int i = 0; i < 40; ++i) y.push_back(i % 2 == 0 ? 1.0 : -1.0);
  CHECK(noise_of(y) == Approx(as_noise(2.0 / std::sqrt(2.0))));
  // A parabola, and a curve of the fifth degree, which the sixth order alone takes away.
  Samples fifth, sixth;
  for (int i = 0; i < 40; ++i) {
    fifth.push_back(std::pow(i - 20.0, 5));
    sixth.push_back(std::pow(i - 20.0, 6));
  }
  CHECK(noise_of(fifth) == Approx(0.0).margin(1e-3));
  CHECK(noise_of(sixth) == Approx(as_noise(720.0 / std::sqrt(924.0))));  // 6! of C(12, 6)
}

TEST_CASE("difference noise: differences are divided by inputs if that is smaller, equal inputs are skipped") {
  CHECK(placed_noise({0, 1, 3, 7}, {0, 1, 3, 7}) == Approx(0.0).margin(1e-12));
  CHECK(noise_of({0, 1, 3, 7}) == Approx(as_noise(2.0 / std::sqrt(6.0))));  // 1 and 2; the third order is one, 1
  CHECK(placed_noise({0, 0, 1, 3, 7}, {5, 0, 1, 3, 7}) == Approx(0.0).margin(1e-12));
  CHECK(placed_noise({2, 2}, {0, 1}) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // as if evenly placed
  // Several stretches together; one without inputs, and none is divided: of the third order there are two now, of 1.
  const Samples x{0, 1, 3, 7}, y{0, 1, 3, 7};
  CHECK(difference_noise(std::vector<Stretch>{{x, y}, {{}, y}}) == Approx(as_noise(1.0 / std::sqrt(20.0))));
  CHECK(difference_noise(std::vector<Stretch>{{{}, Samples{0.0, 1.0}}, {{}, Samples{0.0, 3.0}}, {{}, Samples{0, 2}}}) ==
        Approx(as_noise(2.0 / std::sqrt(2.0))));
}

TEST_CASE("pooled scatter: common and own parts of three rows match hand-computed values") {
  // 1 2 3 and 2 1 6: variances 1 and 7, mean 4; their means 1.5 1.5 4.5: 3, so that 1 is own.
  const std::vector<std::vector<double>> rows{{1, 2}, {2, 1}, {3, 6}};
  const PooledScatter scatter = pooled_scatter(rows);
  CHECK((scatter.rows == 3 && scatter.parts == 2));
  CHECK(scatter.s == Approx(2.0));
  CHECK(scatter.dof == Approx(2.0 * 16.0 / (9.0 + 1.0)));
  CHECK(pooled_scatter(std::vector<std::vector<double>>{{1}, {2}, {3}}).dof == 2.0);
}

TEST_CASE("coverage: degrees of freedom ignore zero shares, and the factor is that of whole degrees") {
  // u 1 and 2 with 3 and 12 degrees: 25 / (1 / 3 + 16 / 12).
  CHECK(effective_dof(std::vector<VarianceShare>{{1.0, 3.0}, {2.0, 12.0}}) == Approx(15.0));
  CHECK(effective_dof(std::vector<VarianceShare>{{1.0, 3.0}, {0.0, 1.0}, {2.0}}) == Approx(75.0));
  CHECK(std::isinf(effective_dof(std::vector<VarianceShare>{{0.0, 3.0}})));
  CHECK(combined_uncertainty(std::vector<VarianceShare>{{3.0}, {4.0}, {12.0}}) == Approx(13.0));
  CHECK(coverage_factor(2.9999999999) == coverage_factor(3.0));  // three, but for rounding
  CHECK(coverage_factor(2.99) == coverage_factor(2.0));
  CHECK_THROWS_AS(coverage_factor(0.99), std::invalid_argument);
  CHECK_THROWS_AS(coverage_factor(3.0, 0.0), std::invalid_argument);
}
