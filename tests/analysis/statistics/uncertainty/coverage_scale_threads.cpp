// When the scale of U is found from runs, condition by condition: on taxels that are straight lines, by hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "tests/analysis/support/straight_budget.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;

namespace {

const std::vector<double> kWholeWay{0, 20, 40, 60, 40, 20, 0}, kPartWay{0, 20, 40, 20};

// The calibration reads 0.1 psi too much and too little: 0.1 sqrt 2 of scatter, and half its square of the mean.
std::vector<SequenceData> scattered_calibration(bool inner) {
  std::vector<SequenceData> sequences{{"loop", {offset_way(kWholeWay, 0.1, 0.1), offset_way(kWholeWay, -0.1, -0.1)}}};
  if (inner) sequences.push_back({"inner", {offset_way(kPartWay, 0.2, 0.2)}});
  return sequences;
}

Dataset run_that_errs(std::int64_t number, const std::string& sequence, const std::vector<double>& way, double off) {
  Dataset run = dataset_of({{sequence, {offset_way(way, off, off)}}});
  run.run = number;
  return run;
}

constexpr std::size_t kAt40Up = 2;  // of the levels: 0, 20, 40, 60 up, then down

constexpr UseCondition kAllConditions[] = {
    UseCondition::kStated,           UseCondition::kFullSweeps, UseCondition::kFittedBranches,
    UseCondition::kAnyHistory,       UseCondition::kOtherDwell, UseCondition::kHeld,
    UseCondition::kOtherTemperature, UseCondition::kRemounted,  UseCondition::kLater};

}  // namespace

TEST_CASE("coverage scale: without runs, and of one held-out run alone, U is not scaled under any condition") {
  StraightBudget made(scattered_calibration(true));
  const Dataset one = run_that_errs(5, "other", kPartWay, 0.5);
  using Kind = std::vector<const Dataset*> HistoryRuns::*;
  const Kind kinds[] = {nullptr,
                        &HistoryRuns::same,
                        &HistoryRuns::dwelt,
                        &HistoryRuns::warm,
                        &HistoryRuns::mounted,
                        &HistoryRuns::later,
                        &HistoryRuns::paced};
  for (const Kind kind : kinds) {
    made.inputs.history = {};
    if (kind != nullptr) made.inputs.history.*kind = {&one};
    const BudgetMaker maker = made.maker();
    for (const UseCondition condition : kAllConditions) {
      CAPTURE(std::find(std::begin(kinds), std::end(kinds), kind) - std::begin(kinds), static_cast<int>(condition));
      CHECK(maker.scale_of(condition) == 1.0);
    }
  }
}

TEST_CASE("coverage scale: one run of the calibration's own sequences tells it for full sweeps and fitted branches") {
  StraightBudget made(scattered_calibration(true));
  // It errs by 0.4 psi at each step between the ends. Own rows: 0.02 and 0.01; the excess row holds what 0.16 has
  // beyond them, so that u of full sweeps is 0.4 psi. U of that would be k times the errors, which it is scaled down
  // to.
  Dataset again = run_that_errs(7, "loop", kWholeWay, 0.4);
  again.sequences.push_back({"inner", {offset_way(kPartWay, 0.4, 0.4)}});
  made.inputs.history.same = {&again};
  const BudgetMaker maker = made.maker();
  CHECK(maker.scale_of(UseCondition::kStated) == 1.0);
  CHECK(maker.scale_of(UseCondition::kAnyHistory) == 1.0);
  const Budget sweeps = maker.budget(0, kAt40Up, UseCondition::kFullSweeps);
  CHECK(sweeps.expanded_psi == Approx(0.4).epsilon(0.03));
  CHECK(maker.scale_of(UseCondition::kFittedBranches) != 1.0);
  // Of the fitted branches every error is 0.4 psi, too: U holds it.
  CHECK(maker.budget(0, kAt40Up, UseCondition::kFittedBranches).expanded_psi >= 0.4 * 0.98);
}

TEST_CASE("coverage scale: two runs that err alike tell each condition its own, others take that of any history") {
  StraightBudget made(scattered_calibration(false));
  const Dataset one = run_that_errs(5, "other", kPartWay, 0.5), two = run_that_errs(6, "other", kPartWay, 0.5);
  const std::vector<const Dataset*> both{&one, &two};
  // Of each condition in turn: whether U is scaled.
  const auto scaled = [&] {
    const BudgetMaker maker = made.maker();
    std::string found;
    for (const UseCondition condition :
         {UseCondition::kStated, UseCondition::kAnyHistory, UseCondition::kOtherDwell, UseCondition::kHeld,
          UseCondition::kOtherTemperature, UseCondition::kRemounted, UseCondition::kLater})
      found += maker.scale_of(condition) == 1.0 ? "-" : "s";
    return found;
  };
  struct Case {
    std::vector<const Dataset*> HistoryRuns::*kind;
    const char* scaled;
  };
  for (const Case& each :
       {Case{&HistoryRuns::same, "-ssssss"}, Case{&HistoryRuns::dwelt, "--s----"}, Case{&HistoryRuns::warm, "----s--"},
        Case{&HistoryRuns::mounted, "-----s-"}, Case{&HistoryRuns::later, "------s"}}) {
    made.inputs.history = {};
    made.inputs.history.*each.kind = both;
    CHECK(scaled() == each.scaled);
  }
}
