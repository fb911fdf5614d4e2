#include "analysis/loop.h"

#include <catch2/catch.hpp>

using namespace tactbench::analysis;

namespace {

std::vector<Sample> steps_of(const std::vector<double>& levels) {
  std::vector<Sample> steps;
  for (const double level : levels) steps.push_back({level, level});
  return steps;
}

}  // namespace

TEST_CASE("set-points split into branches that share their turning points") {
  const auto branches = branches_along(std::vector<double>{0, 2, 4, 2, 0, 2});
  REQUIRE(branches.size() == 3);
  CHECK((branches[0].first == 0 && branches[0].last == 2 && branches[0].ascending));
  CHECK((branches[1].first == 2 && branches[1].last == 4 && !branches[1].ascending));
  CHECK((branches[2].first == 4 && branches[2].last == 5 && branches[2].ascending));
}

TEST_CASE("[A8] held samples keep the last direction") {
  const auto branches = branches_along(std::vector<double>{0, 0, 2, 4, 4, 4, 2, 2, 0});
  REQUIRE(branches.size() == 2);
  CHECK((branches[0].first == 0 && branches[0].last == 5));
  CHECK((branches[1].first == 5 && branches[1].last == 8 && !branches[1].ascending));
  CHECK(branches_along(std::vector<double>{3, 3, 3}).empty());
  CHECK(branches_along(std::vector<double>{3}).empty());
}

TEST_CASE("outputs move to the set-point by the slope of their own branch") {
  // Up along v = p, down along v = 2 p - 4; the reference is off by 0.1 up and -0.2 down.
  SequenceData sequence{"s", {}};
  Repeat repeat;
  for (const double level : {0.0, 2.0, 4.0}) {
    repeat.steps.push_back({level, level + 0.1});
    repeat.volts.push_back(level + 0.1);
  }
  for (const double level : {2.0, 0.0}) {
    repeat.steps.push_back({level, level - 0.2});
    repeat.volts.push_back(2.0 * (level - 0.2) - 4.0);
  }
  sequence.repeats = {repeat, repeat};
  const TaxelTable moved = bring_to_common(sequence, 1);
  CHECK(moved.values[1] == Approx(2.0));
  CHECK(moved.values[2] == Approx(4.0));  // the turning sample belongs to the rise that reached it
  CHECK(moved.values[4] == Approx(-4.0));
  CHECK(moved.pressure_psi == std::vector<double>{0, 2, 4, 2, 0});
  const TaxelTable left = bring_to_common(sequence, 1, {.move_to_setpoint = false});
  CHECK(left.values[1] == Approx(2.1));
  CHECK(left.pressure_psi[3] == Approx(1.8));
}

TEST_CASE("repeats are averaged, chosen, and must be alike") {
  SequenceData sequence{"s", {}};
  for (const double v : {1.0, 2.0, 6.0}) sequence.repeats.push_back({steps_of({0, 2, 0}), {v, v, v}});
  CHECK(bring_to_common(sequence, 1).values[1] == Approx(3.0));
  CHECK(bring_to_common(sequence, 1, {.first_repeat = 2}).values[1] == Approx(6.0));
  CHECK_THROWS_AS(bring_to_common(sequence, 1, {.first_repeat = 3}), AnalysisError);
  sequence.repeats[1].steps[1].setpoint_psi = 3.0;
  CHECK_THROWS_AS(bring_to_common(sequence, 1), AnalysisError);
}

TEST_CASE("the external loop is the mean of the full sweeps only") {
  const std::vector<double> levels{0, 10, 20, 10, 0, 10, 0, 10, 20, 10, 0};
  TaxelTable common;
  common.pressure_psi = levels;
  common.branches = branches_along(levels);
  //             up 1        down 1  inner    up 2      down 2
  common.values = {0, 1, 5, 2, 0, 9, 0, 3, 7, 6, 0};
  const ExternalLoop loop = external_loop(std::vector{common}, 1);
  CHECK(loop.pressure_psi == std::vector<double>{0, 10, 20});
  CHECK(loop.ascending == std::vector<double>{0, 2, 6});
  CHECK(loop.descending == std::vector<double>{0, 4, 6});
}

TEST_CASE("sweeps at slightly different measured pressures come onto one grid") {
  TaxelTable common;
  common.pressure_psi = {0.0, 10.2, 20.0, 9.8, 0.0};
  common.branches = branches_along(std::vector<double>{0, 10, 20, 10, 0});
  common.values = {0.0, 10.2, 20.0, 9.8, 0.0};  // v = p
  const ExternalLoop loop = external_loop(std::vector{common}, 1);
  CHECK(loop.descending[1] == Approx(10.2));
}

TEST_CASE("a missing full sweep is an error that names its direction") {
  TaxelTable common;
  common.pressure_psi = {0, 10, 20, 10};
  common.branches = branches_along(common.pressure_psi);
  common.values = {0, 1, 2, 1};
  try {
    external_loop(std::vector{common}, 1);
    FAIL("accepted");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-ANALYSIS-NO-LOOP");
    CHECK_THAT(error.what(), Catch::Contains("falls"));
  }
  CHECK_THROWS_AS(external_loop({}, 1), AnalysisError);
}
