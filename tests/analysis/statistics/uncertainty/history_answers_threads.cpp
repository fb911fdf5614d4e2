// Rows that further runs give, on taxels that are straight lines: every figure by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/support/straight_budget.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;
using uncertainty_example::known_row;
using uncertainty_example::row_of;

namespace {

constexpr std::size_t kUpAt40 = 2;  // of the levels: 0, 20, 40, 60 up, then down

const std::vector<double> kFullLoop{0, 20, 40, 60, 40, 20, 0};

// Two repeats, whose readings are `off` to either side at each level but 0.
SequenceData calibrated(double off) {
  return erring_way("loop", kFullLoop, {{0, off, off, off, off, off, 0}, {0, -off, -off, -off, -off, -off, 0}});
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

TEST_CASE(
    "the audit's worst taxel: its known error is taken off, 1.8 psi to each side are left, from -0.2 to 3.4 psi") {
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

TEST_CASE("the audit's creeping taxel: half of its creep is taken off, half of it is a rectangle beside the rest") {
  // 30 psi loading in the audit, 40 psi here: creep of up to 2.64 psi, a known error of 0.23, the rest 0.45 psi.
  StraightBudget made({calibrated(0.0)});
  made.errors = thirty_readings(made.errors, 0.23, 0.45 / std::sqrt(31.0 / 30.0));
  HeldLevel held;
  held.sequence = "hold";
  held.pressure_psi = 40.0;
  held.share.assign(3, 2.64 / 40.0);
  made.inputs.creep.levels = {held};
  made.inputs.creep.not_assessed.clear();
  const Budget budget = made.maker().budget(0, kUpAt40);
  CHECK(budget.error_psi == Approx(0.23 + 1.32));
  CHECK(budget.combined_psi == Approx(std::hypot(1.32 / std::sqrt(3.0), 0.45)));
}

TEST_CASE("history row: mean square of held-out reversals less what the own rows have, by hand, its ways as degrees") {
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

TEST_CASE("dwell row: the change between dwell times, an even distribution from none to the whole, by hand") {
  StraightBudget made({calibrated(0.1)});
  // The repeat at 1 s, as in the calibration, is the base; at 4 s the first taxel reads 0.6 psi more at 40 psi upward.
  const Dataset paced =
      dataset_of({erring_way("rate", kFullLoop, {std::vector<double>(7, 0.0), {0, 0, 0.6, 0, 0, 0, 0}}, {1.0, 4.0})});
  made.inputs.history.paced = {&paced};
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kUpAt40);
  const Contribution& row = known_row(budget, UncertaintySource::kDwell);
  CHECK(row.u_psi == Approx(0.6 / std::sqrt(3.0)));
  CHECK(row.common == 1.0);
  CHECK(row_of(maker.budget(1, kUpAt40), UncertaintySource::kDwell)->u_psi == Approx(0.3 / std::sqrt(3.0)));
  CHECK(row_of(maker.budget(0, 1), UncertaintySource::kDwell)->u_psi == Approx(0.0).margin(1e-9));  // 20 psi upward
}
