// Branches, local slopes and full sweeps at their limits, by hand.
#include <catch2/catch.hpp>
#include <vector>

#include "analysis/loop.h"

using namespace tactbench::analysis;

namespace {

TaxelTable table_along(const std::vector<double>& x, const std::vector<double>& y, double turn = 0.0) {
  return {x, y, branches_along(x, turn)};
}

// Outputs 0, 1, 8 at set-points 0, 2, 4 and these references; moved to the set-points.
std::vector<double> moved_from(const std::vector<double>& references) {
  SequenceData sequence{"s", {{}}};
  for (std::size_t i = 0; i < 3; ++i)
    sequence.repeats[0].steps.push_back({2.0 * static_cast<double>(i), references[i]});
  sequence.repeats[0].volts = {0.0, 1.0, 8.0};
  return average_repeats(sequence, 1).values;
}

std::string id_of_repeats(const SequenceData& sequence, const RepeatOptions& options) {
  try {
    (void)average_repeats(sequence, 1, options);
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return "none";
}

double left_out_of(std::size_t outliers, double turn) {
  // A hundred samples: a loop over 0 to 10, and single inputs beyond both ends.
  std::vector<double> x, y;
  for (std::size_t i = 0; i < 100 - 2 * outliers; ++i) {
    const std::size_t half = (100 - 2 * outliers) / 2;
    x.push_back(i < half ? 10.0 * static_cast<double>(i) / static_cast<double>(half - 1)
                         : 10.0 * static_cast<double>(99 - 2 * outliers - i) / static_cast<double>(half - 1));
    y.push_back(x.back());
  }
  TaxelTable table = table_along(x, y, turn);
  for (std::size_t k = 0; k < outliers; ++k)
    for (const double far : {-5.0, 15.0}) {
      table.pressure_psi.push_back(far);
      table.values.push_back(far);
    }
  return external_loop(std::vector{table}, 1, turn).left_out;
}

}  // namespace

TEST_CASE("branches: set-points split into branches that share their turning points") {
  const auto branches = branches_along(std::vector<double>{0, 2, 4, 2, 0, 2});
  REQUIRE(branches.size() == 3);
  CHECK((branches[0].first == 0 && branches[0].last == 2 && branches[0].ascending));
  CHECK((branches[1].first == 2 && branches[1].last == 4 && !branches[1].ascending));
  CHECK((branches[2].first == 4 && branches[2].last == 5 && branches[2].ascending));
}

TEST_CASE("branches: held samples keep the previous direction") {
  const auto branches = branches_along(std::vector<double>{0, 0, 2, 4, 4, 4, 2, 2, 0});
  REQUIRE(branches.size() == 2);
  CHECK((branches[0].first == 0 && branches[0].last == 5));
  CHECK((branches[1].first == 5 && branches[1].last == 8 && !branches[1].ascending));
  CHECK(branches_along(std::vector<double>{3, 3, 3}).empty());
  CHECK(branches_along(std::vector<double>{3}).empty());
}

TEST_CASE("branches: a direction starts or reverses only when the input moves by more than the tolerance") {
  const auto count = [](const std::vector<double>& x) { return branches_along(x, 0.5).size(); };
  CHECK(count({0, 1, 0.5, 1.5}) == 1);
  CHECK(count({0, 1, 0.4375, 1.5}) == 3);
  CHECK(count({2, 1, 1.5, 0}) == 1);
  CHECK(count({2, 1, 1.5625, 0}) == 3);
  CHECK(count({0, 0.5, 0, 0.5}) == 0);
  CHECK(count({0, 0.5625}) == 1);
  CHECK(count({0, -0.5625}) == 1);
  CHECK(count({}) == 0);
  const auto branches = branches_along(std::vector<double>{1, 1.5, 0.25, 0.75, 1}, 0.5);
  REQUIRE(branches.size() == 2);
  CHECK((branches[0].first == 0 && branches[0].last == 2 && !branches[0].ascending));
  CHECK((branches[1].first == 2 && branches[1].last == 4 && branches[1].ascending));
}

TEST_CASE("average_repeats: outputs move to the set-point along the slope of their own branch") {
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
  const TaxelTable moved = average_repeats(sequence, 1);
  CHECK(moved.values[1] == Approx(2.0));
  CHECK(moved.values[2] == Approx(4.0));  // the turning sample belongs to the rise that reached it
  CHECK(moved.values[4] == Approx(-4.0));
  CHECK(moved.pressure_psi == std::vector<double>{0, 2, 4, 2, 0});
  const TaxelTable left = average_repeats(sequence, 1, {.move_to_setpoint = false});
  CHECK(left.values[1] == Approx(2.1));
  CHECK(left.pressure_psi[3] == Approx(1.8));
}

TEST_CASE("local slope: uses the commanded step if the reference moved by less than a tenth of it") {
  // Moved by 4: 2 a psi. By half a psi: 16. By less than 0.4, back, or not at all: 2 of the commanded 4.
  CHECK(moved_from({0.0, 1.5, 4.0})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 2.25})[1] == Approx(1.0 + 16.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 2.125})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 1.75})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 0.0})[1] == Approx(1.0 + 2.0 * 0.5));
  // At the ends of a branch to one side: 0.5 a psi at the first, 3.5 at the last.
  CHECK(moved_from({-0.5, 1.5, 4.0})[0] == Approx(0.0 + 0.5 * 0.5));
  CHECK(moved_from({0.0, 1.5, 3.5})[2] == Approx(8.0 + 3.5 * 0.5));
  // A pressure that is held has no slope there.
  SequenceData held{"s", {{}}};
  for (const auto& [psi, reference] : {std::pair{0.0, 0.0}, {2.0, 2.0}, {2.0, 2.5}, {2.0, 2.5}})
    held.repeats[0].steps.push_back({psi, reference});
  held.repeats[0].volts = {0.0, 1.0, 2.0, 3.0};
  CHECK(average_repeats(held, 1).values[3] == 3.0);
}

TEST_CASE("average_repeats: averages the requested repeats, and refuses a range with a missing repeat") {
  SequenceData sequence{"s", {}};
  for (const double v : {1.0, 2.0, 6.0, 20.0}) sequence.repeats.push_back({{{0, 0}, {2, 2}, {0, 0}}, {v, v, v}});
  const auto mean = [&](int first, int last) {
    RepeatOptions options;
    options.first_repeat = first;
    options.last_repeat = last;
    return average_repeats(sequence, 1, options).values[1];
  };
  CHECK(mean(0, 0) == 1.0);
  CHECK(mean(0, 1) == Approx(1.5));
  CHECK(mean(1, 2) == Approx(4.0));
  CHECK(mean(1, -1) == Approx(28.0 / 3.0));
  CHECK(mean(3, 3) == 20.0);
  CHECK(id_of_repeats(sequence, {.first_repeat = 0, .last_repeat = 3}) == "none");
  CHECK(id_of_repeats(sequence, {.first_repeat = 0, .last_repeat = 4}) == "TB-ANALYSIS-REPEATS");
  CHECK(id_of_repeats(sequence, {.first_repeat = 2, .last_repeat = 1}) == "TB-ANALYSIS-REPEATS");
  CHECK(id_of_repeats(sequence, {.first_repeat = -1, .last_repeat = 1}) == "TB-ANALYSIS-REPEATS");
  // Measured pressures are averaged as well.
  sequence.repeats[0].steps[1].reference_psi = 1.0;
  sequence.repeats[1].steps[1].reference_psi = 1.5;
  const TaxelTable plain = average_repeats(sequence, 1, {.move_to_setpoint = false, .last_repeat = 1});
  CHECK(plain.pressure_psi[1] == Approx(1.25));
  CHECK(plain.values[1] == Approx(1.5));
  // Repeats that were not asked for may have other set-points.
  sequence.repeats[3].steps[1].setpoint_psi = 3.0;
  CHECK(id_of_repeats(sequence, {.first_repeat = 0, .last_repeat = 2}) == "none");
  CHECK(id_of_repeats(sequence, {.first_repeat = 0, .last_repeat = 3}) == "TB-ANALYSIS-REPEATS");
}

TEST_CASE("external loop: sweeps within 1 % of both ends are full, and are extrapolated to the ends of the grid") {
  // Up to 100 and down; up to 99 and down to 1, which are full; up to 98 and down to 0, which are not.
  const TaxelTable table = table_along({0, 100, 0, 99, 1, 98, 0}, {0, 10, 0, 20, 0, 1000, 0});
  const ExternalLoop loop = external_loop(std::vector{table}, 1);
  CHECK(loop.pressure_psi == std::vector<double>{0, 100});
  CHECK(loop.ascending[0] == Approx(0.0).margin(1e-12));
  CHECK(loop.ascending[1] == Approx(0.5 * (10.0 + 20.0 * 100.0 / 99.0)));
  CHECK(loop.descending[0] == Approx(0.5 * (0.0 - 20.0 / 98.0)));
  CHECK(loop.descending[1] == Approx(0.5 * (10.0 + 20.0 * 99.0 / 98.0)));
  CHECK(loop.left_out == 0.0);
  // The finest rise is the grid, without steps that do not advance; of two taxels each has its own.
  TaxelTable two = {{0, 10, 0, 5, 5, 10, 0}, {0, 1, 10, 11, 0, 1, 4, 5, 4, 5, 12, 13, 2, 3}, {}};
  two.branches = branches_along(two.pressure_psi);
  const ExternalLoop both = external_loop(std::vector{two}, 2);
  CHECK(both.pressure_psi == std::vector<double>{0, 5, 10});
  CHECK(both.ascending == std::vector<double>{0, 1, 4.5, 5.5, 11, 12});
  CHECK(both.descending == std::vector<double>{1, 2, 6, 7, 11, 12});
}

TEST_CASE("external loop: up to 2 % of measured samples may lie beyond either end, but no commanded ones") {
  CHECK(left_out_of(0, 0.01) == 0.0);
  CHECK(left_out_of(1, 0.01) == 0.01);
  CHECK(left_out_of(2, 0.01) == 0.02);
  CHECK_THROWS_AS(left_out_of(3, 0.01), AnalysisError);
  CHECK(left_out_of(0, 0.0) == 0.0);
  CHECK_THROWS_AS(left_out_of(1, 0.0), AnalysisError);
  // With a turn of 5 the ends may be as far away.
  CHECK(left_out_of(1, 5.0) == 0.0);
}

TEST_CASE("external loop: a missing full sweep is an error") {
  TaxelTable common;
  common.pressure_psi = {0, 10, 20, 10};
  common.branches = branches_along(common.pressure_psi);
  common.values = {0, 1, 2, 1};
  try {
    external_loop(std::vector{common}, 1);
    FAIL("accepted");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-ANALYSIS-NO-LOOP");
  }
  CHECK_THROWS_AS(external_loop({}, 1), AnalysisError);
}
