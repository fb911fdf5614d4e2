// Pooled scatter and its degrees of freedom, against cases on paper.
#include "analysis/statistics/numbers/pooled_scatter.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace tactbench::analysis;

TEST_CASE("pooled scatter: parts that move as one have no more than n - 1 degrees of freedom") {
  const std::vector<std::vector<double>> rows = {{1.0, 11.0, 21.0}, {3.0, 13.0, 23.0}};
  const PooledScatter scatter = pooled_scatter(rows);
  CHECK(scatter.s == Approx(std::sqrt(2.0)));
  CHECK(scatter.dof == Approx(1.0));
  CHECK(scatter.parts == 3);
}

TEST_CASE("pooled scatter: parts that move against each other add up their degrees of freedom") {
  // Each part has the variance 2, their mean stands still: (n - 1)(parts - 1) = 3.
  const std::vector<std::vector<double>> rows = {{1.0, 2.0, 5.0, 8.0}, {3.0, 0.0, 7.0, 6.0}};
  const PooledScatter scatter = pooled_scatter(rows);
  CHECK(scatter.s == Approx(std::sqrt(2.0)));
  CHECK(scatter.dof == Approx(3.0));
}

TEST_CASE("pooled scatter: a part that is not finite is left out, and one row or no part tells nothing") {
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
