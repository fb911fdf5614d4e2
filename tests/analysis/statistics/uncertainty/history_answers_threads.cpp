// Rows that further runs give, and the scale of U from runs that it was not found from, on taxels that are straight
// lines: every figure by hand.
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
const std::vector<double> kInnerWay{0, 20, 40, 20};  // one branch up to 40, one down: neither is full

// Two repeats, whose readings are `off` to either side at each level but 0.
SequenceData calibrated(double off) {
  return erring_way("loop", kFullLoop, {{0, off, off, off, off, off, 0}, {0, -off, -off, -off, -off, -off, 0}});
}

// A held-out run of four sequences, each once along kInnerWay; every reading of the first taxel errs by `off`.
Dataset held_out_run(std::int64_t number, double off) {
  std::vector<SequenceData> sequences;
  for (const char* name : {"a", "b", "c", "d"})
    sequences.push_back(erring_way(name, kInnerWay, {{off, off, off, off}}));
  Dataset run = dataset_of(std::move(sequences));
  run.run = number;
  return run;
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
  const Budget budget = made.maker().budget(0, kUpAt40, UseCondition::kFullSweeps);
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

TEST_CASE("history row: mean square of held-out errors less what the own rows have, by hand, its ways as degrees") {
  StraightBudget made({calibrated(0.1)});
  // At 40 psi upward two ways a run: the branch up to 40 of either sequence.
  const auto run_with = [](std::int64_t number, double first, double second) {
    Dataset run =
        dataset_of({erring_way("x", kInnerWay, {{0, 0, first, 0}}), erring_way("y", kInnerWay, {{0, 0, second, 0}})});
    run.run = number;
    return run;
  };
  const Dataset one = run_with(5, 0.5, 0.7), two = run_with(6, -0.3, 0.1);
  made.inputs.history.same = {&one, &two};
  const BudgetMaker maker = made.maker();
  for (const std::size_t taxel : {0U, 1U}) {
    INFO("taxel " << taxel);
    const double half = taxel == 0 ? 1.0 : 0.5;
    const Budget budget = maker.budget(taxel, kUpAt40, UseCondition::kAnyHistory);
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
  // One such run is not enough to have a U of its own.
  made.inputs.history.same = {&one};
  CHECK(row_of(made.maker().budget(0, kUpAt40, UseCondition::kAnyHistory), UncertaintySource::kHistory) == nullptr);
}

TEST_CASE("excess row: what full sweeps of a repeated run err by beyond the calibration's own scatter, by hand") {
  const SequenceData inner = erring_way("inner", kInnerWay, {{0, 0, 0.6, 0}});
  StraightBudget made({calibrated(0.1), inner});
  Dataset again = dataset_of({erring_way("loop", kFullLoop, {{0, 0.4, 0.4, 0.4, 0.4, 0.4, 0}}), inner});
  again.run = 7;
  made.inputs.history.same = {&again};
  const BudgetMaker maker = made.maker();
  const Budget sweeps = maker.budget(0, kUpAt40, UseCondition::kFullSweeps);
  const Contribution& excess = known_row(sweeps, UncertaintySource::kHistory);
  // 0.4^2 against 0.03 of the own rows: 4.33 times as much beyond them, in both taxels, one way, all in common but for
  // the halves: of the mean square (1 + 1/4) / 2 the mean's (3/4)^2.
  CHECK(excess.u_psi == Approx(std::sqrt(0.16 - 0.03)));
  const double common = 0.5625 / 0.625;
  CHECK(excess.common == Approx(common));
  CHECK(excess.dof == Approx(1.0 / (common * common + (1.0 - common) * (1.0 - common))));
  // The fitted branches: their own mean square beyond the rows, and the same excess; each frame counts.
  const Budget branches = maker.budget(0, kUpAt40, UseCondition::kFittedBranches);
  const Contribution& fitted = known_row(branches, UncertaintySource::kHistory);
  CHECK(fitted.u_psi == Approx(std::sqrt(0.36 - 0.03 + 0.13)));
  CHECK(fitted.dof == 1);
  CHECK(maker.not_valid(UseCondition::kFullSweeps).empty());
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

TEST_CASE("coverage scale: each run against U of the other, by hand, and U of both times it") {
  // A calibration without scatter: the history is all there is. Each run has four ways, k of four degrees of freedom is
  // 2.87 (GUM, Table G.2, for 95.45 %).
  StraightBudget made({calibrated(0.0)});
  const double a = 0.50, b = 0.55;
  const Dataset one = held_out_run(5, a), two = held_out_run(6, b);
  made.inputs.history.same = {&one, &two};
  const BudgetMaker maker = made.maker();
  CHECK(maker.not_valid(UseCondition::kAnyHistory).empty());
  // Run 5 errs by a / (2.87 b) of U, run 6 by b / (2.87 a): the upper 4.55 % are of these.
  CHECK(maker.scale_of(UseCondition::kAnyHistory) == Approx(b / (2.87 * a)).epsilon(0.002));
  // U of both: eight ways, k = 2.37; the mean square of the two.
  const Budget budget = maker.budget(0, kUpAt40, UseCondition::kAnyHistory);
  CHECK(budget.expanded_psi ==
        Approx(maker.scale_of(UseCondition::kAnyHistory) * 2.37 * std::sqrt((a * a + b * b) / 2.0)).epsilon(0.003));
  CHECK_FALSE(maker.basis(UseCondition::kAnyHistory).empty());
  // The reference's own error, which all runs share, is not scaled: u = 0.3 psi beside the history's u.
  made.reference.certificate_missing.clear();
  made.reference.reading_psi = {0.0};
  made.reference.expanded_psi = {0.6};
  const Budget with = made.maker().budget(0, kUpAt40, UseCondition::kAnyHistory);
  const double scale = maker.scale_of(UseCondition::kAnyHistory), history = std::sqrt((a * a + b * b) / 2.0);
  CHECK(made.maker().scale_of(UseCondition::kAnyHistory) == Approx(scale));
  const double k = with.expanded_psi / std::hypot(0.3, scale * history);
  CHECK(with.dof == Approx(8.0 * std::pow(std::hypot(0.3, history) / history, 4)));
  CHECK(k == Approx(2.25).margin(0.15));  // between eight degrees of freedom, 2.37, and very many, 2.00
}

TEST_CASE("runs of a kind whose errors leave more than 6 % open make U invalid for any history, and more runs help") {
  // Runs that err by 0.5 psi and by `ratio` times that. Of two the standard deviation is ln(ratio) / sqrt(2), and their
  // mean is known to ln(ratio) / 2. Of two of each kind: of the logarithms ln(ratio) / sqrt(3), and half of it.
  for (const double ratio : {1.12, 1.14, 1.21, 1.25}) {
    INFO("ratio " << ratio);
    StraightBudget made({calibrated(0.0)});
    std::vector<Dataset> runs;
    for (const double off : {0.5, 0.5 * ratio, 0.5, 0.5 * ratio})
      runs.push_back(held_out_run(static_cast<std::int64_t>(5 + runs.size()), off));
    made.inputs.history.same = {&runs[0], &runs[1]};
    const std::string of_two = made.maker().not_valid(UseCondition::kAnyHistory);
    made.inputs.history.same = {&runs[0], &runs[1], &runs[2], &runs[3]};
    const std::string of_four = made.maker().not_valid(UseCondition::kAnyHistory);
    CHECK(of_two.empty() == (ratio < 1.13));   // 5.7, 6.6, 9.5, 11.2 %
    CHECK(of_four.empty() == (ratio < 1.23));  // 3.3, 3.8, 5.5, 6.4 %
  }
}

TEST_CASE("runs that differ under one condition count there above all") {
  StraightBudget made({calibrated(0.0)});
  std::vector<Dataset> runs;
  for (const double off : {0.5, 0.5, 0.5, 0.5, 0.5, 0.65})
    runs.push_back(held_out_run(static_cast<std::int64_t>(5 + runs.size()), off));
  made.inputs.history.same = {&runs[0], &runs[1]};
  made.inputs.history.warm = {&runs[2], &runs[3]};
  made.inputs.history.later = {&runs[4], &runs[5]};
  // ln(1.3) = 0.262: a square of 0.0344 with one degree of freedom, pooled with two of none 0.0115. Of the pair that
  // differs sqrt((4 0.0115 + 0.0344) / 5) = 12.7 %, of the others sqrt(4 0.0115 / 5) = 9.6 %; over sqrt(2) 9.0, 6.8 %.
  const BudgetMaker maker = made.maker();
  CHECK_THAT(maker.not_valid(UseCondition::kLater), Catch::Contains(" 13 %") && Catch::Contains(" 9.0 %"));
  CHECK_THAT(maker.not_valid(UseCondition::kAnyHistory), Catch::Contains(" 6.8 %"));
  // Twice as many of the others make them valid, and less of the pair.
  made.inputs.history.same = {&runs[0], &runs[1], &runs[2], &runs[3]};
  made.inputs.history.warm = {&runs[0], &runs[1], &runs[2], &runs[3]};
  const BudgetMaker more = made.maker();
  CHECK(more.not_valid(UseCondition::kAnyHistory).empty());
  CHECK(more.not_valid(UseCondition::kOtherTemperature).empty());
  CHECK_THAT(more.not_valid(UseCondition::kLater), Catch::Contains(" 7.4 %"));
}
