// What ELAM's searches look at, by hand: units of an even grid, ends that no parameter moves, curves of one turn.
#include <catch2/catch.hpp>
#include <vector>

#include "analysis/identify/elam/lanes.h"

using namespace tactbench::analysis;

TEST_CASE("ELAM's searches by hand: units of an even grid, ends that no parameter moves, curves of one turn") {
  const std::vector<double> x{10, 20, 30, 40}, y{1, 2, 4, 5};
  const ElamModel model{PatternCurve(x, y, 1.0, 5.0), PatternCurve(x, y, 1.0, 5.0), {}, {}};
  // Down from (30, 3): at 10 psi the end, 1 V, at 30 and above the turn; between them in order.
  const std::vector<CurveSamples> down{{30, 3, {25, 10, 15, 30, 35}, {2, 1.5, 1.25, 2, 3}, {1, 2, 3, 4, 5}}};
  const LaneProblem falls = lane_problem(model, down, false);
  CHECK((falls.x0 == 0.0 && falls.xu == 3.0 && falls.y0 == 1.0 && falls.yu == 5.0));
  CHECK(falls.constant == 2 * 0.25 + 4 * 1.0);
  CHECK(falls.x == std::vector<double>{0.5, 1.5});
  CHECK(falls.y == std::vector<double>{1.25, 2});
  CHECK(falls.weight == std::vector<double>{3, 1});
  CHECK(falls.pattern == std::vector<double>{0.5, 2});  // 1.5 and 3 V less 1
  REQUIRE(falls.curves.size() == 1);
  CHECK((falls.curves[0].first == 0 && falls.curves[0].end == 2));
  CHECK((falls.curves[0].x_turn == 2.0 && falls.curves[0].y_turn == 3.0 && falls.curves[0].rise == 2.0));
  CHECK((falls.curves[0].length == 1.0 && falls.curves[0].share == Approx(1.0 / 3.0)));
  CHECK(falls.curves[0].x_pattern == 1.5);
  // Up from (15, 6), which lies above the range: 5 V.
  const std::vector<CurveSamples> up{{15, 6, {40, 15, 20}, {4, 4.5, 5}, {1, 2, 1}}, {20, 0.5, {30}, {3}, {1}}};
  const LaneProblem rises = lane_problem(model, up, true);
  CHECK(rises.constant == 1.0 + 2 * 0.25);
  CHECK(rises.x == std::vector<double>{1, 2});
  CHECK(rises.pattern.empty());
  REQUIRE(rises.curves.size() == 2);
  CHECK((rises.curves[0].x_turn == 0.5 && rises.curves[0].y_turn == 5.0 && rises.curves[0].rise == 0.0));
  CHECK((rises.curves[0].x_pattern == 3.0 && rises.curves[0].length == 2.5));
  CHECK((rises.curves[1].first == 1 && rises.curves[1].end == 2 && rises.curves[1].rise == 4.0));
  CHECK((rises.curves[1].y_turn == 1.0 && rises.curves[1].x_pattern == 0.0));
}
