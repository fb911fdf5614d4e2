// What taxels have in common of the scatter of sweeps, of held-out errors, and what is left where nothing scatters: by
// hand, on taxels that are straight lines.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_budget.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;
using uncertainty_example::known_row;
using uncertainty_example::row_of;

namespace {

constexpr std::size_t kAtTwentyUp = 1, kAtFortyUp = 2, kAtFortyDown = 6;

const std::vector<double> kUpAndDown{0, 20, 40, 60, 40, 20, 0};

// Two repeats: the taxels are so much off in the first one, and as much to the other side in the second.
StraightBudget two_sides(double first_off, double second_off) {
  return StraightBudget(
      {{"loop", {offset_way(kUpAndDown, first_off, second_off), offset_way(kUpAndDown, -first_off, -second_off)}}});
}

// Of the mean of six readings in two groups.
double of_mean_of(double within, double between) { return within / 6.0 + between / 2.0; }

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
  StraightBudget made({{"low", {offset_way(kUpAndDown, 0.1, 0.1), offset_way(kUpAndDown, -0.1, -0.1)}},
                       {"high", {offset_way(kUpAndDown, 0.5, 0.3), offset_way(kUpAndDown, 0.3, 0.1)}}});
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

TEST_CASE("readings in groups of two and of four by hand: scatter within, between and of the mean, noise taken off") {
  StraightBudget made = two_sides(0.0, 0.0);
  // Group 0 reads 1 and 3, group 2 5, 5, 7 and 7; no reading is of group 1. The second taxel reads half of it.
  const std::vector<double> first{1, 5, 3, 7, 5, 7};
  made.errors.groups = 3;
  for (LevelReadings& level : made.errors.levels) {
    level.readings = 6;
    level.group = {0, 2, 0, 2, 2, 2};
    level.error_psi.clear();
    for (const double error : first) level.error_psi.insert(level.error_psi.end(), {error, 0.5 * error, kNan});
  }
  // Within: 2 and 4 of four degrees, 1.5. Means 2 and 6 about 28 / 6: 2 x 64 / 9 + 4 x 16 / 9 = 64 / 3 of one degree;
  // a group counts as (6 - (4 + 16) / 6) = 8 / 3 readings.
  const double within = 1.5, between = (64.0 / 3.0 - 1.5) / (8.0 / 3.0);
  for (const std::size_t taxel : {0U, 1U}) {
    const double half = taxel == 0 ? 1.0 : 0.5;
    const Budget budget = made.maker().budget(taxel, kAtFortyUp);
    CHECK(budget.error_psi == Approx(half * 28.0 / 6.0));
    CHECK(budget.readings == 6);
    const Contribution *repeats = row_of(budget, UncertaintySource::kRepeatability),
                       *groups = row_of(budget, UncertaintySource::kConditioning),
                       *model = row_of(budget, UncertaintySource::kModel);
    REQUIRE((repeats != nullptr && groups != nullptr && model != nullptr));
    CHECK(repeats->u_psi == Approx(half * std::sqrt(within)));
    CHECK(repeats->dof == 4.0);
    CHECK(groups->u_psi == Approx(half * std::sqrt(between)));
    CHECK(groups->dof == 1.0);
    const double of_mean = of_mean_of(within, between);
    CHECK(model->u_psi == Approx(half * std::sqrt(of_mean)));
    CHECK(model->dof == Approx(of_mean * of_mean / (std::pow(within / 6.0, 2) / 4.0 + std::pow(between / 2.0, 2))));
    for (const Contribution* row : {repeats, groups, model}) CHECK(row->common == Approx(0.9));
  }
  // Noise of 2 psi is more than the scatter within: nothing is left of it, and the mean is known from the noise.
  made.calibration.scans = 3;
  made.calibration.noise_v = {0.1, 0.1, 0.0};
  const Budget noisy = made.maker().budget(0, kAtFortyUp);
  CHECK(row_of(noisy, UncertaintySource::kNoise)->u_psi == Approx(2.0));
  CHECK(row_of(noisy, UncertaintySource::kRepeatability)->u_psi == 0.0);
  CHECK(row_of(noisy, UncertaintySource::kModel)->u_psi == Approx(std::sqrt(4.0 / 6.0 + between / 2.0)));
  // Of 1 psi a third of the variance is left.
  made.calibration.noise_v = {0.05, 0.1, 0.0};
  CHECK(row_of(made.maker().budget(0, kAtFortyUp), UncertaintySource::kRepeatability)->u_psi == Approx(std::sqrt(0.5)));
  CHECK(row_of(made.maker().budget(0, kAtFortyUp), UncertaintySource::kModel)->u_psi ==
        Approx(std::sqrt(of_mean_of(within, between))));
}

TEST_CASE("a budget is linear as long as twice u of the voltage meets the curve's end and does not pass it") {
  StraightBudget made = two_sides(0.0, 0.0);
  made.calibration.scans = 2;
  const auto linear = [&](double noise_v, std::size_t level) {
    made.calibration.noise_v = {noise_v, 0.001, 0.0};
    return made.maker().budget(0, level).linear;
  };
  // 20 psi are 1 V above the curve's begin, 40 psi 1 V below its end.
  CHECK(linear(0.5, kAtTwentyUp));
  CHECK_FALSE(linear(0.50001, kAtTwentyUp));
  CHECK(linear(0.5, kAtFortyUp));
  CHECK_FALSE(linear(0.50001, kAtFortyUp));
}

TEST_CASE("a run without a full sweep has no level with U, and the first is the one whose budget would be printed") {
  const StraightBudget made({{"inner", {offset_way({0, 20, 40, 20, 0}, 0.1, 0.1)}}});
  const Uncertainty found = assess_uncertainty(made.calibration, made.fit, {}, {}, 1);
  CHECK(found.levels.empty());
  CHECK(found.chosen == 0);
  CHECK(found.level(40.0, true) == nullptr);
}
