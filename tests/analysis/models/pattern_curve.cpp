#include "analysis/models/pattern_curve.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

using tactbench::analysis::PatternCurve;
using Values = std::vector<double>;

namespace {

void check_strictly_rising(const PatternCurve& curve) {
  for (std::size_t i = 1; i < curve.y().size(); ++i) REQUIRE(curve.y()[i] > curve.y()[i - 1]);
}

}  // namespace

TEST_CASE("PatternCurve: a rising curve is kept bit for bit and interpolated linearly") {
  const Values x{0, 2, 4, 10}, y{0.1, 0.3, 0.9, 1.7};
  const PatternCurve curve(x, y, 0.1, 1.7);
  CHECK(Values(curve.y().begin(), curve.y().end()) == y);
  CHECK(curve(3.0) == Approx(0.6));
  CHECK(curve(-1.0) == 0.1);
  CHECK(curve(11.0) == 1.7);
  CHECK(curve.inverse(0.6) == Approx(3.0));
  CHECK(curve.inverse(0.0) == 0.0);
  CHECK(curve.inverse(2.0) == 10.0);
  CHECK(curve.slope(3.0) == Approx(0.3));
  CHECK(curve.slope(2.0) == Approx(0.3));
  CHECK(curve.slope(99.0) == Approx(0.8 / 6.0));
}

TEST_CASE("PatternCurve: falling outputs are replaced by their mean, between fixed ends") {
  for (const auto& [y, low, high, pooled] :
       {std::tuple{Values{0, 3, 1, 2, 5}, 0.0, 5.0, Values{0, 2, 2, 2, 5}},
        // 4 | 5 3 -> 4 | 4 4; then 2.5 pulls all three down: mean of 4, 5, 3, 2.5.
        {Values{0, 4, 5, 3, 2.5, 9}, 0.0, 9.0, Values{0, 3.625, 3.625, 3.625, 3.625, 9}},
        {Values{9, -1, 7, 9}, 0.0, 5.0, Values{0, 0, 5, 5}},
        // At the first or at the last step alone.
        {Values{1, 0.5, 2, 3}, 1.0, 3.0, Values{1, 1, 2, 3}},
        {Values{1, 2, 3.5, 3}, 1.0, 3.0, Values{1, 2, 3, 3}}}) {
    Values x;
    while (x.size() < y.size()) x.push_back(static_cast<double>(x.size()));
    const PatternCurve curve(x, y, low, high);
    CAPTURE(y);
    check_strictly_rising(curve);
    CHECK(curve.y().front() == low);
    CHECK(curve.y().back() == high);
    for (std::size_t i = 0; i < x.size(); ++i) CHECK(curve.y()[i] == Approx(pooled[i]).margin(1e-7));
  }
}

TEST_CASE("PatternCurve: a saturated curve keeps the minimum slope and can be inverted") {
  const PatternCurve curve(Values{0, 20, 40, 60}, Values{0, 3.5, 3.5, 3.5}, 0, 3.5);
  check_strictly_rising(curve);
  CHECK((curve.y()[3] - curve.y()[2]) / 20.0 == Approx(1e-9 * 3.5 / 60.0).epsilon(1e-3));
  const double middle = 0.5 * (curve.y()[2] + curve.y()[3]);
  CHECK(curve.inverse(middle) == Approx(50.0).margin(1e-3));
}

TEST_CASE("PatternCurve: a curve that is already monotone is not changed") {
  const PatternCurve once(Values{0, 1, 2, 3, 4, 5}, Values{0, 3, 1, 2, 5, 4.9}, 0, 5);
  const PatternCurve twice(once.x(), once.y(), once.y().front(), once.y().back());
  CHECK(Values(once.y().begin(), once.y().end()) == Values(twice.y().begin(), twice.y().end()));
}

TEST_CASE("PatternCurve: a step of half the minimum slope is kept, a smaller one is raised to the minimum") {
  // Over 2 and 2: the minimum is 1e-9.
  CHECK(PatternCurve(Values{0, 1, 2}, Values{0, 0.5 * 1e-9, 2}, 0, 2).y()[1] == 0.5 * 1e-9);
  CHECK(PatternCurve(Values{0, 1, 2}, Values{0, 0.49 * 1e-9, 2}, 0, 2).y()[1] == Approx(1e-9));
}

TEST_CASE("PatternCurve: knots too close for the minimum slope are refused, at the first and the last step") {
  CHECK_THROWS_AS(PatternCurve(Values{0, 1e-12, 2}, Values{1, 0.5, 3}, 1, 3), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 2 - 1e-12, 2}, Values{1, 3.5, 3}, 1, 3), std::invalid_argument);
}

TEST_CASE("PatternCurve: grids need not be uniform") {
  const Values x{0, 0.1, 0.2, 50, 59, 60}, y{0, 1, 2, 3, 4, 5};
  const PatternCurve curve(x, y, 0, 5);
  for (std::size_t i = 0; i < x.size(); ++i) CHECK(curve(x[i]) == Approx(y[i]));
  for (double v = 0.05; v < 5.0; v += 0.1) CHECK(curve(curve.inverse(v)) == Approx(v).epsilon(1e-12));
}

TEST_CASE("PatternCurve: invalid curves are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(PatternCurve(Values{0}, Values{0}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 1}, Values{0}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 0}, Values{0, 1}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, nan}, Values{0, 1}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 1}, Values{0, inf}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 1}, Values{0, 1}, 0, nan), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 1}, Values{0, 1}, 1, 1), std::invalid_argument);
  CHECK_THROWS_AS(PatternCurve(Values{0, 1}, Values{1, 0}, 1, 0), std::invalid_argument);
}
