// U by kind of history on taxels that are straight lines: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;

namespace {

const std::vector<double> kLoop{0, 20, 40, 60, 40, 20, 0}, kReversing{0, 60, 0, 40, 20, 40, 0, 20, 0, 44, 0};

// Every reading but at the ends errs by `off`, of the second taxel by half of it.
Dataset run_that_errs(std::int64_t number, const std::vector<double>& way, double off) {
  Dataset run = dataset_of({{"any", {offset_way(way, off, 0.5 * off)}}});
  run.run = number;
  return run;
}

std::vector<ConditionUncertainty> counted_of(const StraightBudget& made, double unobservable_u_psi = 0.0) {
  const BudgetMaker maker = made.maker();
  return empirical_uncertainty(maker.counted(), made.fit, maker.corrections(), made.errors.levels,
                               [=](double) { return unobservable_u_psi; });
}

const ConditionUncertainty& of(const std::vector<ConditionUncertainty>& all, UseCondition which) {
  return all[static_cast<std::size_t>(which)];
}

StraightBudget calibrated() {
  return StraightBudget({{"loop", {offset_way(kLoop, 0.0, 0.0), offset_way(kLoop, 0.0, 0.0)}}});
}

}  // namespace

TEST_CASE("empirical U: histories with equal errors have k = 1, and U equals their error") {
  StraightBudget made = calibrated();
  const Dataset one = run_that_errs(5, kReversing, 0.5), two = run_that_errs(6, kReversing, 0.5);
  made.inputs.history.same = {&one, &two};
  const auto all = counted_of(made);
  const ConditionUncertainty& found = of(all, UseCondition::kReversals);
  REQUIRE(found.valid());
  CHECK((found.histories == 2 && found.runs == std::vector<std::int64_t>{5, 6}));
  CHECK(found.factor == Approx(1.0).epsilon(1e-6));
  CHECK(reading_uncertainty(found, 0, 40.0, true).expanded_psi == Approx(0.5));
  CHECK(reading_uncertainty(found, 1, 20.0, false).expanded_psi == Approx(0.25));
  CHECK(std::isnan(reading_uncertainty(found, 2, 20.0, false).expanded_psi));
  // What no run can show is added with k = 2: U = hypot(2 u, 0.5).
  CHECK(reading_uncertainty(of(counted_of(made, 0.3), UseCondition::kReversals), 0, 40.0, true).expanded_psi ==
        Approx(std::hypot(0.6, 0.5)));
  CHECK_FALSE(of(counted_of(made, kNan), UseCondition::kReversals).valid());
  CHECK_FALSE(of(all, UseCondition::kHeld).valid());
}

TEST_CASE("empirical U: each history is compared with the others, and a single one gives no U") {
  StraightBudget made = calibrated();
  const Dataset one = run_that_errs(5, kReversing, 0.50), two = run_that_errs(6, kReversing, 0.55);
  made.inputs.history.same = {&one};
  CHECK_FALSE(of(counted_of(made), UseCondition::kReversals).valid());
  made.inputs.history.same = {&one, &two};
  const ConditionUncertainty found = of(counted_of(made), UseCondition::kReversals);
  REQUIRE(found.valid());
  // Where the other erred by 0.50 this one needs 1.1 times that; the upper 4.55 % of both are of these. The shape that
  // the kinds share is theirs and that of the sweeps in them, which err by the same.
  // What two such leave open: half of the difference of the logarithms ln 1.21, over 2, and over the root of 2 twice;
  // the upper quartile of that.
  CHECK(found.factor == Approx(1.1 * std::exp(0.674 * std::log(1.21) / 4.0)).epsilon(0.02));
  CHECK(reading_uncertainty(found, 0, 40.0, true).expanded_psi ==
        Approx(found.factor * std::sqrt((0.50 * 0.50 + 0.55 * 0.55) / 2.0)).epsilon(0.001));
}

TEST_CASE("empirical U: a few histories with very different errors give no U, more such histories give one") {
  StraightBudget made = calibrated();
  std::vector<Dataset> runs;
  for (int i = 0; i < 16; ++i) runs.push_back(run_that_errs(5 + i, kReversing, i % 2 == 0 ? 0.5 : 1.1));
  made.inputs.history.same = {&runs[0], &runs[1]};
  const ConditionUncertainty few = of(counted_of(made), UseCondition::kReversals);
  CHECK((!few.valid() && few.histories == 2 && few.expanded_psi.empty()));
  made.inputs.history.same.clear();
  for (const Dataset& run : runs) made.inputs.history.same.push_back(&run);
  CHECK(of(counted_of(made), UseCondition::kReversals).valid());
}

TEST_CASE("empirical U: a run in another state is one history, and counts for that state only") {
  StraightBudget made = calibrated();
  Dataset one = run_that_errs(5, kReversing, 0.5);
  one.sequences.push_back(one.sequences.front());
  made.inputs.history.later = {&one};
  CHECK_FALSE(of(counted_of(made), UseCondition::kLater).valid());
  const Dataset two = run_that_errs(6, kReversing, 0.5);
  made.inputs.history.later = {&one, &two};
  const auto all = counted_of(made);
  CHECK((of(all, UseCondition::kLater).valid() && of(all, UseCondition::kLater).histories == 2));
  CHECK(of(all, UseCondition::kReversals).histories == 0);
  CHECK_FALSE(worst_of(all).has_value());
  // At another dwell: the same way, ten times as long at each level.
  Dataset slow = one, slow_too = two;
  for (Dataset* run : {&slow, &slow_too})
    for (SequenceData& sequence : run->sequences)
      for (Sample& sample : sequence.repeats.front().steps) sample.held_s = 10.0;
  made.inputs.history = {};
  made.inputs.history.same = {&slow, &slow_too};
  CHECK(of(counted_of(made), UseCondition::kOtherDwell).valid());
}

// Rows that further runs give, on taxels that are straight lines: every figure by hand.

using uncertainty_example::known_row;
using uncertainty_example::row_of;

namespace {

constexpr std::size_t kUpAt40 = 2;  // of the levels: 0, 20, 40, 60 up, then down

// Two repeats, whose readings are `off` to either side at each level but 0.
SequenceData calibrated(double off) {
  return erring_way("loop", kLoop, {{0, off, off, off, off, off, 0}, {0, -off, -off, -off, -off, -off, 0}});
}

// 30 readings of each taxel at each level, of one group: this mean, and exactly this standard deviation.
SweepErrors thirty_readings(const SweepErrors& like, double mean, double s) {
  SweepErrors errors = like;
  errors.groups = 1;
  const double off = s * std::sqrt(29.0 / 30.0);
  for (LevelReadings& level : errors.levels) {
    level.readings = 30;
    level.group.assign(30, 0);
    level.error_psi.clear();
    for (int reading = 0; reading < 30; ++reading)
      level.error_psi.insert(level.error_psi.end(), 3, mean + (reading % 2 == 0 ? off : -off));
  }
  return errors;
}

}  // namespace

TEST_CASE("budget: a known error of 1.6 psi is corrected, and U of 1.83 psi remains") {
  StraightBudget made({calibrated(0.0)});
  made.errors = thirty_readings(made.errors, 1.6, 0.8614);
  const Budget budget = made.maker().budget(0, kUpAt40);
  // One reading, and the mean of 30 that is taken off: s sqrt(1 + 1/30), about 30 degrees of freedom, k = 2.087.
  CHECK(budget.error_psi == Approx(1.6));
  CHECK(budget.expanded_psi == Approx(2.087 * 0.8614 * std::sqrt(31.0 / 30.0)).epsilon(0.001));
  CHECK(budget.expanded_psi == Approx(1.83).margin(0.005));  // before: 8.8
  CHECK(budget.lower_psi() == Approx(-0.2).margin(0.05));
  CHECK(budget.upper_psi() == Approx(3.4).margin(0.05));
}

TEST_CASE("budget: half of a taxel's creep is corrected, the other half is a rectangular part") {
  // 30 psi loading in the audit, 40 psi here: creep of up to 2.64 psi, a known error of 0.23, the rest 0.45 psi.
  StraightBudget made({calibrated(0.0)});
  made.errors = thirty_readings(made.errors, 0.23, 0.45 / std::sqrt(31.0 / 30.0));
  const HeldLevel held{.sequence = "hold", .pressure_psi = 40.0, .share = std::vector<double>(3, 2.64 / 40.0)};
  made.inputs.creep.levels = {held};
  made.inputs.creep.not_assessed.clear();
  const Budget budget = made.maker().budget(0, kUpAt40);
  CHECK(budget.error_psi == Approx(0.23 + 1.32));
  CHECK(budget.combined_psi == Approx(std::hypot(1.32 / std::sqrt(3.0), 0.45)));
}

TEST_CASE("history row: is the mean square of held-out reversals less the other rows, with their number as degrees") {
  StraightBudget made({calibrated(0.1)});
  // After full pressure down to 20, up to 50 and down again; twice at 40 psi on the way up.
  const auto run_with = [](std::int64_t number, double first, double second) {
    const std::vector<double> way{0, 60, 10, 40, 50, 5, 40, 55, 0};
    Dataset run = dataset_of({erring_way("x", way, {{0, 0, 0, first, 0, 0, second, 0, 0}})});
    run.run = number;
    return run;
  };
  const Dataset one = run_with(5, 0.5, 0.7), two = run_with(6, -0.3, 0.1);
  made.inputs.history.same = {&one, &two};
  const BudgetMaker maker = made.maker();
  for (const std::size_t taxel : {0U, 1U}) {
    INFO("taxel " << taxel);
    const double half = taxel == 0 ? 1.0 : 0.5;
    const Budget budget = maker.budget(taxel, kUpAt40);
    // Own rows: readings +-0.1 about 0, one group: s^2 = 0.02, and s^2 / 2 of the mean that is taken off.
    CHECK(row_of(budget, UncertaintySource::kRepeatability)->u_psi == Approx(half * std::sqrt(0.02)));
    CHECK(row_of(budget, UncertaintySource::kModel)->u_psi == Approx(half * std::sqrt(0.01)));
    const Contribution& history = known_row(budget, UncertaintySource::kHistory);
    const double square = (0.25 + 0.49 + 0.09 + 0.01) / 4.0;
    CHECK(history.u_psi == Approx(half * std::sqrt(square - 0.03)));
    CHECK(history.dof == 4);
    // The array's mean errs by three quarters of the first taxel: of the second's square more than the whole.
    CHECK(history.common == Approx(taxel == 0 ? 0.5625 : 1.0));
  }
}

TEST_CASE("dwell row: is rectangular from zero to the change between dwell times") {
  StraightBudget made({calibrated(0.1)});
  // The repeat at 1 s, as in the calibration, is the base; at 4 s the first taxel reads 0.6 psi more at 40 psi upward.
  const Dataset paced =
      dataset_of({erring_way("rate", kLoop, {std::vector<double>(7, 0.0), {0, 0, 0.6, 0, 0, 0, 0}}, {1.0, 4.0})});
  made.inputs.history.paced = {&paced};
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kUpAt40);
  const Contribution& row = known_row(budget, UncertaintySource::kDwell);
  CHECK(row.u_psi == Approx(0.6 / std::sqrt(3.0)));
  CHECK(row.common == 1.0);
  CHECK(row_of(maker.budget(1, kUpAt40), UncertaintySource::kDwell)->u_psi == Approx(0.3 / std::sqrt(3.0)));
  CHECK(row_of(maker.budget(0, 1), UncertaintySource::kDwell)->u_psi == Approx(0.0).margin(1e-9));  // 20 psi upward
}
