// What ELAM's searches look at of samples and patterns, to the last bit, as it was when recorded: tables of patterns on
// even and uneven grids, curves and samples in their units, splits.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/elam/lanes.h"
#include "tests/analysis/compensate/recorded_streams.h"
#include "tests/analysis/support/bits.h"

using namespace tactbench::analysis;
using recorded::Numbers;
using to_the_bit::Bits;

namespace {

struct Patterns {
  std::vector<double> x, up, down;
};

Patterns patterns_on(int grid) {
  Patterns made;
  made.x = grid == 0   ? std::vector<double>{5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55}
           : grid == 1 ? std::vector<double>{0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0, 49.0, 60.0}
           : grid == 2 ? std::vector<double>{0.0, 0.1, 0.2, 0.30000000000000004, 0.4}
                       : std::vector<double>{2.0, 2.5, 60.0, 61.0, 61.5, 62.0};
  for (const double x : made.x) {
    const double share = (x - made.x.front()) / (made.x.back() - made.x.front());
    made.up.push_back(0.75 + 3.0 * share * share);
    made.down.push_back(grid == 3 ? 0.75 + 3.0 * std::min(1.0, 1.25 * share) : 0.75 + 3.0 * share * (2.0 - share));
  }
  made.up.back() = made.down.back() = 3.75;
  return made;
}

void add_table(Bits& bits, const LaneTable& table, const PatternCurve& curve) {
  bits.add_count(table.uniform() ? 1 : 0);
  bits.add_count(table.last());
  for (const double x : curve.x())
    for (const double near : {to_the_bit::just_below(x), x, to_the_bit::just_above(x)}) {
      const double u = std::clamp(table.unit(near), table.unit(curve.x().front()), table.unit(curve.x().back()));
      bits.add(table.unit(near));
      bits.add(table.back(u));
      bits.add(table.value(u));
      bits.add_count(table.segment(u));
    }
  for (int k = 0; k < 64; ++k) {
    const double x = curve.x().front() + (curve.x().back() - curve.x().front()) * k / 64.0;
    bits.add(table.value(table.unit(x)));
  }
  for (const double y : curve.y())
    for (const double near : {to_the_bit::just_below(y), y, to_the_bit::just_above(y), y + 0.03125, y - 0.03125}) {
      const LaneTable::Place place = table.inverse(std::clamp(near, curve.y().front(), curve.y().back()));
      bits.add(place.u);
      bits.add(place.by_y);
    }
  const std::size_t segments = curve.x().size() - 1;
  for (std::size_t i = 0; i < 2 * segments; ++i) {
    bits.add(table.rows()[i]);
    bits.add(table.places()[i]);
  }
  bits.add(table.rows()[2 * segments]);
}

void add_problem(Bits& bits, const LaneProblem& problem) {
  for (const double own : {problem.x0, problem.xu, problem.y0, problem.yu, problem.smallest_rise, problem.constant})
    bits.add(own);
  for (const LaneCurve& curve : problem.curves) {
    bits.add_count(curve.first);
    bits.add_count(curve.end);
    for (const double own : {curve.x_turn, curve.y_turn, curve.x_pattern, curve.length, curve.share, curve.rise})
      bits.add(own);
  }
  for (const std::vector<double>* list : {&problem.x, &problem.y, &problem.weight, &problem.pattern}) {
    bits.add_count(list->size());
    for (const double own : *list) bits.add(own);
  }
}

// Samples at the ends, beyond them, at knots and anywhere, out of order; turns beyond the range and inside.
std::vector<CurveSamples> drawn_samples(Numbers& number, const Patterns& made) {
  const double low = made.x.front(), span = made.x.back() - low;
  std::vector<CurveSamples> curves;
  for (int c = 0; c < 6; ++c) {
    CurveSamples& own = curves.emplace_back();
    const double kind = number();
    own.x_turn = kind < 0.2 ? low : kind < 0.4 ? low + span : kind < 0.5 ? low - 1.0 : low + span * number();
    own.y_turn = 0.5 + 3.5 * number();
    for (int i = 0; i < 9; ++i) {
      own.x.push_back(i == 0   ? low
                      : i == 1 ? low + span
                      : i == 2 ? own.x_turn
                      : i == 3 ? low - 0.5
                      : i == 4 ? made.x[2]
                               : low + span * number());
      own.y.push_back(0.5 + 3.5 * number());
      own.weight.push_back(1.0 + std::floor(4.0 * number()));
    }
  }
  return curves;
}

std::string problems_on(int grid) {
  Bits bits;
  Numbers number(static_cast<std::uint64_t>(60 + grid));
  const Patterns made = patterns_on(grid);
  const ElamModel model{PatternCurve(made.x, made.up, 0.75, 3.75), PatternCurve(made.x, made.down, 0.75, 3.75), {}, {}};
  add_table(bits, LaneTable(model.ascending), model.ascending);
  add_table(bits, LaneTable(model.descending), model.descending);
  for (int n = 0; n < 40; ++n) {
    const std::vector<CurveSamples> curves = drawn_samples(number, made);
    add_problem(bits, lane_problem(model, curves, false));
    const LaneProblem problem = lane_problem(model, curves, true);
    add_problem(bits, problem);
    AscendingLanes lanes(problem, 3 + static_cast<std::size_t>(n) % 8);
    bits.add_count(lanes.stride);
    for (std::size_t i = 0; i < lanes.stride; ++i) {
      bits.add(lanes.u[i] + 2.0 * lanes.v[i] + 4.0 * lanes.beta[i]);
      lanes.beta[i] = i == 0 ? 0.0 : i == 1 ? 1.0 : number();
      if (i % 3 != 2) lanes.split(i);
      bits.add_count(lanes.is_split[i] ? 1 : 0);
    }
    for (const double own : lanes.splits) bits.add(own);
    for (const double own : lanes.by_beta) bits.add(own);
  }
  return bits.text();
}

}  // namespace

TEST_CASE("recorded: what ELAM's searches look at is the same to the last bit") {
  const std::vector<std::string> was{"85ff73dda3eaea89", "1a6a60b0e2d35a13", "4bc54583252eaa5d", "1fc320f52cc59e5c"};
  std::vector<std::string> now;
  for (int grid = 0; grid < 4; ++grid) now.push_back(problems_on(grid));
  CHECK(now == was);
}

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
