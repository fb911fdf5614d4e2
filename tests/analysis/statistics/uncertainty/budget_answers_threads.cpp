// What an assessor found in the budgets, each with an answer that is known beforehand: zero return that is noise alone,
// groups of sweeps that differ, mounts, taxels that err together.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/studies/studies.h"
#include "analysis/statistics/uncertainty/budget_maker.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace uncertainty_example;

namespace {

double squares_of(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  return row == nullptr ? 0.0 : row->u_psi * row->u_psi;
}

// Readings of full sweeps as they are wished: taxels x groups x readings, at every level.
SweepErrors wished(const SweepErrors& like, std::size_t taxels, const std::vector<int>& group,
                   const std::function<double(std::size_t taxel, std::size_t reading)>& error) {
  SweepErrors errors = like;
  errors.groups = 1 + *std::ranges::max_element(group);
  for (LevelReadings& level : errors.levels) {
    level.readings = group.size();
    level.group = group;
    level.error_psi.clear();
    for (std::size_t reading = 0; reading < group.size(); ++reading)
      for (std::size_t taxel = 0; taxel < taxels; ++taxel) level.error_psi.push_back(error(taxel, reading));
  }
  return errors;
}

}  // namespace

TEST_CASE("a zero return that is noise alone adds nothing, however many repeats there are") {
  // Outputs whose zero never moves: noise of 1 mV a frame and no more.
  const Example example;
  const ReferenceUncertainty reference = reference_uncertainty(record_with_reference(kWithCertificate));
  std::mt19937_64 random(71);
  std::normal_distribution<double> noise(0.0, 0.001);
  for (const std::size_t repeats : {3U, 10U, 100U}) {
    double zero = 0.0, of_noise = 0.0;
    for (int trial = 0; trial < 40; ++trial) {
      Dataset dataset = example.dataset;
      dataset.noise_v.assign(3, 0.001);
      SweepErrors errors = sweep_errors(dataset, example.fit);
      errors.repeats_with_zero = repeats;
      for (std::size_t taxel = 0; taxel < 3; ++taxel) {
        std::vector<double> returns;
        for (std::size_t repeat = 0; repeat < repeats; ++repeat) returns.push_back(noise(random) - noise(random));
        errors.zero_return_v[taxel] = mean_of(returns);
        errors.zero_return_s_v[taxel] = sample_deviation(returns);
      }
      const UncertaintyInputs none;
      const BudgetMaker maker(dataset, example.fit, errors, reference, 0.0, none);
      const Budget budget = maker.budget(1, 15);
      zero += squares_of(budget, UncertaintySource::kZeroReturn);
      of_noise += squares_of(budget, UncertaintySource::kNoise);
    }
    // Before: half-width of the largest of ten, 2.7 noises, whose variance is 2.5 times that of the noise.
    INFO(repeats << " repeats");
    CHECK(zero < 2.0 * of_noise / static_cast<double>(repeats));
  }
}

TEST_CASE("sweeps that differ by what lies before them are groups, with their own degrees of freedom") {
  const Example example;
  const SweepErrors like = sweep_errors(example.dataset, example.fit);
  const ReferenceUncertainty reference = reference_uncertainty(record_with_reference(kWithCertificate));
  const UncertaintyInputs none;
  // 5 readings of one group and 25 of another, 0.2 psi apart; scatter of 0.11 psi within each.
  std::vector<int> group(30, 1);
  std::fill_n(group.begin(), 5, 0);
  std::mt19937_64 random(72);
  std::normal_distribution<double> normal;
  const auto errors = wished(like, 3, group, [&](std::size_t, std::size_t reading) {
    return (group[reading] == 0 ? 0.2 : 0.0) + 0.11 * normal(random);
  });
  const BudgetMaker maker(example.dataset, example.fit, errors, reference, 0.0, none);
  const Budget budget = maker.budget(1, 15, UseCondition::kFullSweeps);
  const Contribution *within = row_of(budget, UncertaintySource::kRepeatability),
                     *between = row_of(budget, UncertaintySource::kConditioning);
  REQUIRE(within != nullptr);
  REQUIRE(between != nullptr);
  CHECK(within->dof == 28);
  CHECK(between->dof == 1);
  // Two groups 0.2 psi apart have a standard deviation of 0.2 / sqrt(2).
  CHECK(between->u_psi == Approx(0.2 / std::sqrt(2.0)).margin(0.05));
  const double total =
      squares_of(budget, UncertaintySource::kRepeatability) + squares_of(budget, UncertaintySource::kNoise);
  CHECK(std::sqrt(total) == Approx(0.11).margin(0.03));
  // Groups that do not differ have no effect between them, on average.
  const auto alike = wished(like, 3, group, [&](std::size_t, std::size_t) { return 0.11 * normal(random); });
  const BudgetMaker none_between(example.dataset, example.fit, alike, reference, 0.0, none);
  CHECK(row_of(none_between.budget(1, 15), UncertaintySource::kConditioning)->u_psi < 0.08);
}

TEST_CASE("a known error is taken off and is no part of U, and who does not correct has both ends") {
  const Example example;
  const SweepErrors like = sweep_errors(example.dataset, example.fit);
  const ReferenceUncertainty reference = reference_uncertainty(record_with_reference(kWithCertificate));
  const UncertaintyInputs none;
  std::mt19937_64 random(73);
  std::normal_distribution<double> normal(0.0, 0.3);
  std::vector<int> group(30);
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i % 6);
  // The audit's worst taxel: 2.6 psi off on average; before, U was 8.8 psi.
  const auto errors = wished(like, 3, group, [&](std::size_t, std::size_t) { return 2.6 + normal(random); });
  const BudgetMaker maker(example.dataset, example.fit, errors, reference, 0.0, none);
  const Budget budget = maker.budget(1, 15, UseCondition::kFullSweeps);
  CHECK(budget.error_psi == Approx(2.6).margin(0.25));
  CHECK(budget.expanded_psi < 1.0);
  CHECK(budget.expanded_psi > 0.5);
  CHECK(budget.lower_psi() == Approx(2.6 - budget.expanded_psi).margin(0.25));
  CHECK(budget.upper_psi() == Approx(2.6 + budget.expanded_psi).margin(0.25));
}

TEST_CASE("mounts: a common part and the taxels' own, with the degrees of freedom of each") {
  // Estimates of 200 taxels at two levels in mounts whose sensitivity differs: 1 % in common, 2 % a taxel's own.
  constexpr std::size_t kMountedTaxels = 200;
  const auto mounts_of = [](int count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::vector<MountedRun> mounts;
    for (int mount = 0; mount < count; ++mount) {
      MountedRun run;
      run.run = mount + 1;
      run.estimates.pressure_psi = {20.0, 40.0};
      run.estimates.sweeps = 1;
      run.estimates.taxels = static_cast<int>(kMountedTaxels);
      const double common = 0.01 * normal(random);
      std::vector<double> own;
      for (std::size_t taxel = 0; taxel < kMountedTaxels; ++taxel) own.push_back(0.02 * normal(random));
      for (const double level : run.estimates.pressure_psi)
        for (const double share : own) run.estimates.psi.push_back(level * (1.0 + common + share));
      mounts.push_back(run);
    }
    return mounts;
  };
  const Remount two = remount_of(mounts_of(2, 1));
  CHECK(two.degrees == 1);
  CHECK(two.own_degrees == 199);
  CHECK(two.own_share == Approx(0.02).epsilon(0.25));
  double common = 0.0, own = 0.0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const Remount found = remount_of(mounts_of(4, seed));
    CHECK(found.own_degrees == 3 * 199);
    CHECK(std::hypot(found.common_share, found.own_share) == Approx(found.s_share));
    common += found.common_share * found.common_share / 200.0;
    own += found.own_share * found.own_share / 200.0;
  }
  CHECK(std::sqrt(common) == Approx(0.01).epsilon(0.1));
  CHECK(std::sqrt(own) == Approx(0.02).epsilon(0.03));
}

TEST_CASE("U of the array's mean has the common parts whole and the taxels' own over their number") {
  Example example(0.0015, 9);
  UncertaintyInputs inputs;
  inputs.mounting = GivenUncertainty{0.0, 0.02, kInfiniteDof, "mounts"};
  const db::RunRecord run = record_with_reference(kWithCertificate);
  const Uncertainty common = assess_uncertainty(example.dataset, example.fit, run, inputs);
  inputs.mounting.reset();
  inputs.mounting_own = GivenUncertainty{0.0, 0.02, kInfiniteDof, "mounts"};
  const Uncertainty own = assess_uncertainty(example.dataset, example.fit, run, inputs);
  const Uncertainty without = assess_uncertainty(example.dataset, example.fit, run);
  const auto added = [&](const Uncertainty& with) {
    return std::sqrt(std::pow(with.level(40.0, true)->array.mean_u_psi, 2) -
                     std::pow(without.level(40.0, true)->array.mean_u_psi, 2));
  };
  CHECK(added(common) == Approx(0.8).epsilon(1e-6));
  CHECK(added(own) == Approx(0.8 / 3.0).epsilon(1e-6));
  // What all taxels have in common moves no centre of pressure.
  CHECK(common.level(40.0, true)->array.centre_expanded ==
        Approx(without.level(40.0, true)->array.centre_expanded).epsilon(1e-9));
  CHECK(own.level(40.0, true)->array.centre_expanded > without.level(40.0, true)->array.centre_expanded);
}

TEST_CASE("a condition that was not assessed states why, and U is not valid for it") {
  const Example example;
  const Uncertainty alone = assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  REQUIRE(alone.conditions.size() == kUseConditions - 1);
  for (const UseCondition condition : {UseCondition::kFullSweeps, UseCondition::kFittedBranches})
    CHECK_FALSE(alone.condition(condition).not_valid.empty());
  CHECK_FALSE(alone.condition(UseCondition::kOtherDwell).not_valid.empty());
  for (const UseCondition condition :
       {UseCondition::kAnyHistory, UseCondition::kHeld, UseCondition::kOtherTemperature, UseCondition::kRemounted}) {
    CHECK_THAT(alone.condition(condition).not_valid, Catch::Contains("random-reversal"));
    CHECK(alone.condition(condition).expanded_psi.empty());
  }
  CHECK_THAT(alone.condition(UseCondition::kLater).not_valid, Catch::Contains("another day"));

  // A held-out run of the array with reversals of its own, whose errors are those of the fitted branches.
  const synthetic::Array array({.rows = 1, .columns = 3, .sensor_seed = 4});
  Dataset other = synthetic::run(array, {.seed = 10, .noise_v = 0.0015, .repeats = 1});
  for (SequenceData& data : other.sequences) data.name += "-other";  // else it repeats the calibration
  UncertaintyInputs inputs;
  const Dataset again = synthetic::run(array, {.seed = 11, .noise_v = 0.0015, .repeats = 2});
  Dataset second = synthetic::run(array, {.seed = 12, .noise_v = 0.0015, .repeats = 1});
  for (SequenceData& data : second.sequences) data.name += "-second";
  inputs.history.same = {&other, &again};
  CHECK_FALSE(assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate), inputs)
                  .condition(UseCondition::kAnyHistory)
                  .not_valid.empty());
  inputs.history.same.push_back(&second);
  inputs.history.later = {&other};
  const Uncertainty with =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate), inputs);
  CHECK(with.condition(UseCondition::kAnyHistory).valid());
  CHECK_THAT(with.condition(UseCondition::kRemounted).not_valid, Catch::Contains("mounted anew"));
  for (const UseCondition condition : {UseCondition::kFullSweeps, UseCondition::kFittedBranches})
    CHECK(with.condition(condition).valid());
  CHECK_FALSE(with.condition(UseCondition::kLater).not_valid.empty());
  // Runs that differ in noise alone need about the U that each of them finds for the other.
  CHECK(with.condition(UseCondition::kAnyHistory).scale == Approx(1.0).margin(0.35));
  const ReadingUncertainty at = reading_uncertainty(with.condition(UseCondition::kAnyHistory), 1, 31.0, true);
  const ReadingUncertainty low = reading_uncertainty(with.condition(UseCondition::kAnyHistory), 1, 30.0, true);
  const ReadingUncertainty high = reading_uncertainty(with.condition(UseCondition::kAnyHistory), 1, 32.0, true);
  CHECK(at.expanded_psi == Approx(0.5 * (low.expanded_psi + high.expanded_psi)));
  CHECK(at.error_psi == Approx(0.5 * (low.error_psi + high.error_psi)));
}
