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
  CHECK(mean_by_shares(Doubles{1.0, 2.0, 5.0, 8.0}) == 4.0);
  CHECK(mean_of(Doubles{0.1, 0.2, 0.3}) == 0.20000000000000004);
  CHECK(mean_by_shares(Doubles{0.1, 0.2, 0.3}) == 0.2);
  CHECK(std::isnan(mean_of(Doubles{})));
  CHECK(std::isnan(mean_by_shares(Doubles{})));
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

TEST_CASE("moments: least-squares line, its residual and the correlation match hand-computed values") {
  const Doubles x{0.0, 1.0, 2.0, 3.0, 4.0}, y{1.0, 3.0, 5.0, 7.0, 9.0};
  for (const LineFit& line : {line_fit(x, y), line_fit_by_shares(x, y)}) {
    CHECK(line.slope() == Approx(2.0));
    CHECK(line.at_zero() == Approx(1.0));
    CHECK(line.correlation() == Approx(1.0));
    CHECK(residual_sum_of_squares(line, x, y) == Approx(0.0).margin(1e-20));
  }
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
