// U by kind of history on taxels that are straight lines: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/support/straight_budget.h"

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

std::vector<ConditionUncertainty> counted_of(const StraightBudget& made, double hidden_psi = 0.0) {
  const BudgetMaker maker = made.maker();
  return counted_uncertainty(maker.counted(), made.fit, maker.corrections(), made.errors.levels,
                             [=](double) { return hidden_psi; });
}

const ConditionUncertainty& of(const std::vector<ConditionUncertainty>& all, UseCondition which) {
  return all[static_cast<std::size_t>(which)];
}

StraightBudget calibrated() {
  return StraightBudget({{"loop", {offset_way(kLoop, 0.0, 0.0), offset_way(kLoop, 0.0, 0.0)}}});
}

}  // namespace

TEST_CASE("counted U: histories that err alike are held by k of 1, and U is what they err by") {
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

TEST_CASE("counted U: each history against the others, by hand, and one alone says nothing") {
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

TEST_CASE("counted U: histories that differ too much leave it open, and more of them help") {
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

TEST_CASE("counted U: a run in another state is one history, whatever it went through, and tells of that state alone") {
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
