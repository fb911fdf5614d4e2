// What taxels have in common of the scatter of sweeps, of held-out errors, and what is left where nothing scatters: by
// hand, on taxels that are straight lines.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_budget.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;
using uncertainty_example::row_of;

namespace {

constexpr std::size_t kAtTwentyUp = 1, kAtFortyUp = 2, kAtFortyDown = 6;

const std::vector<double> kUpAndDown{0, 20, 40, 60, 40, 20, 0};

Repeat offset_reading(const std::vector<double>& psi, double first_off, double second_off) {
  std::vector<Sample> steps;
  Readings readings;
  for (const double level : psi) {
    const bool end = level == 0.0 || level == 60.0;
    steps.push_back({level, level, 0.0, 1.0});
    readings.first_psi.push_back(level + (end ? 0.0 : first_off));
    readings.second_psi.push_back(level + (end ? 0.0 : second_off));
  }
  return repeat_of(steps, readings);
}

// Two repeats: the taxels are so much off in the first one, and as much to the other side in the second.
StraightBudget two_sides(double first_off, double second_off) {
  return StraightBudget(
      {{"loop",
        {offset_reading(kUpAndDown, first_off, second_off), offset_reading(kUpAndDown, -first_off, -second_off)}}});
}

double common_of(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  return row == nullptr ? kNan : row->common;
}

}  // namespace

TEST_CASE("common scatter by hand: the variance of the array's mean over the mean of the taxels' own, none or all") {
  struct Case {
    double first, second, common;
  };
  for (const Case& each : {Case{0.1, 0.1, 1.0},      // alike
                           Case{0.1, -0.1, 0.0},     // against each other: the mean stands still
                           Case{0.2, 0.1, 0.9},      // means 0.15: 0.0225 over (0.04 + 0.01) / 2
                           Case{0.2, 0.0, 0.5},      // means 0.1: 0.01 over 0.02
                           Case{0.3, -0.1, 0.2}}) {  // means 0.1: 0.01 over 0.05
    CAPTURE(each.first, each.second);
    const StraightBudget made = two_sides(each.first, each.second);
    const BudgetMaker maker = made.maker();
    for (const std::size_t level : {kAtTwentyUp, kAtFortyUp, kAtFortyDown})
      for (const std::size_t taxel : {0U, 1U}) {
        const Budget budget = maker.budget(taxel, level);
        CHECK(common_of(budget, UncertaintySource::kRepeatability) == Approx(each.common).margin(1e-9));
        CHECK(common_of(budget, UncertaintySource::kModel) == Approx(each.common).margin(1e-9));
      }
    // At the ends nothing scatters.
    CHECK(common_of(maker.budget(0, 0), UncertaintySource::kRepeatability) == 0.0);
  }
}

TEST_CASE("common scatter by hand: of the groups of sweeps, too, and U of the array's mean is from it") {
  // Two sequences of two repeats each: groups of sweeps that differ by 0.4 and 0.2 psi.
  StraightBudget made({{"low", {offset_reading(kUpAndDown, 0.1, 0.1), offset_reading(kUpAndDown, -0.1, -0.1)}},
                       {"high", {offset_reading(kUpAndDown, 0.5, 0.3), offset_reading(kUpAndDown, 0.3, 0.1)}}});
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kAtFortyUp);
  // Means of the array 0.1 -0.1 0.4 0.2: squares 0.13 about 0.15. Of the taxels 0.1 -0.1 0.5 0.3: 0.20 about 0.2; 0.1
  // -0.1 0.3 0.1: 0.08 about 0.1.
  CHECK(common_of(budget, UncertaintySource::kConditioning) == Approx(0.13 / 0.14));
  CHECK(common_of(budget, UncertaintySource::kRepeatability) == Approx(0.13 / 0.14));
  // Within: 0.02 and 0.02 of two degrees; between: 2 x 2 x 0.04 = 0.16 of one, less 0.02 within, over two readings.
  CHECK(row_of(budget, UncertaintySource::kRepeatability)->u_psi == Approx(std::sqrt(0.02)));
  CHECK(row_of(budget, UncertaintySource::kRepeatability)->dof == 2.0);
  CHECK(row_of(budget, UncertaintySource::kConditioning)->u_psi == Approx(std::sqrt(0.07)));
  CHECK(row_of(budget, UncertaintySource::kConditioning)->dof == 1.0);
  // The mean of four readings in two groups.
  CHECK(row_of(budget, UncertaintySource::kModel)->u_psi == Approx(std::sqrt(0.02 / 4 + 0.07 / 2)));
}

TEST_CASE("held-out runs that err by nothing: a row of nothing, of which nothing is common") {
  StraightBudget made = two_sides(0.0, 0.0);
  const std::vector<double> inner{0, 20, 40, 20};
  Dataset one = dataset_of({{"other", {offset_reading(inner, 0.0, 0.0)}}}), two = one;
  one.run = 5;
  two.run = 6;
  made.inputs.history.same = {&one, &two};
  const Budget budget = made.maker().budget(0, kAtFortyUp, UseCondition::kAnyHistory);
  const Contribution* const row = row_of(budget, UncertaintySource::kHistory);
  REQUIRE(row != nullptr);
  CHECK(row->u_psi == Approx(0.0).margin(1e-9));
  CHECK(row->common == 0.0);
  CHECK(budget.expanded_psi == Approx(0.0).margin(1e-9));
}

TEST_CASE("a run without a full sweep has no level with U, and the first is the one whose budget would be printed") {
  const StraightBudget made({{"inner", {offset_reading({0, 20, 40, 20, 0}, 0.1, 0.1)}}});
  const Uncertainty found = assess_uncertainty(made.calibration, made.fit, {}, {}, 1);
  CHECK(found.levels.empty());
  CHECK(found.chosen == 0);
  CHECK(found.level(40.0, true) == nullptr);
}
