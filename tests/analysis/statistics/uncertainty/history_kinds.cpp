// What a trajectory is evidence for, as one table, and the histories that a run counts as.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/statistics/uncertainty/empirical_errors.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

// Each step a second after the command; of steps with equal set-points each two seconds after the one before.
SequenceData along(const std::vector<double>& setpoints, int repeats = 1) {
  SequenceData sequence{"any", {}};
  for (int repeat = 0; repeat < repeats; ++repeat) {
    Repeat own = offset_way(setpoints, 0.0, 0.0);
    for (std::size_t i = 1; i < own.steps.size(); ++i)
      if (setpoints[i] == setpoints[i - 1]) own.steps[i].held_s = own.steps[i - 1].held_s + 2.0;
    sequence.repeats.push_back(own);
  }
  return sequence;
}

// A letter a step: Full sweeps, Reversals, Small reversals, Held, - none.
std::string kinds_of(const std::vector<double>& setpoints, bool pressed = false) {
  std::string letters;
  for (const std::optional<UseCondition>& kind : history_kinds(along(setpoints), 0.0, 60.0, pressed))
    letters += !kind ? '-' : "FRSH"[static_cast<std::size_t>(*kind)];
  return letters;
}

}  // namespace

TEST_CASE("history kinds: each frame of a trajectory has the expected kind") {
  struct Row {
    const char* what;
    std::vector<double> setpoints;
    bool pressed;
    const char* kinds;
  };
  const Row rows[] = {
      {"a sweep", {0, 30, 60, 30, 0}, false, "FFFFF"},
      {"a sweep to 54 psi", {0, 30, 54, 30, 0}, true, "-----"},
      {"reversals after a loop", {0, 60, 0, 50, 10, 40, 20, 55, 0}, false, "FFFRRRRRR"},
      {"the same, full pressure not reached first", {0, 50, 10, 40, 20, 55, 0}, false, "-------"},
      {"the same, full pressure reached before", {0, 50, 10, 40, 20, 55, 0}, true, "RRRRRRR"},
      {"reversals in the middle of the range", {0, 60, 0, 40, 20, 40, 22, 38, 0}, true, "FFF------"},
      {"small reversals", {0, 20, 16, 20, 14, 18, 16, 20, 0}, true, "SSSSSSSSS"},
      {"small reversals, never above 20 psi", {0, 20, 16, 20, 14, 18, 16, 20, 0}, false, "---------"},
      {"too few of them", {0, 20, 16, 20, 0}, true, "-----"},
      {"reversals of 9 psi in the median are small, of 10 not", {0, 9, 0, 9, 0, 9, 0}, true, "SSSSSSS"},
      {"", {0, 10, 0, 10, 0, 10, 0}, true, "-------"},
      {"held at 30 and 50 psi", {0, 30, 30, 30, 30, 0, 50, 50, 50, 50, 0}, false, "-HHHH-HHHH-"},
      {"read twice, not held", {0, 30, 30, 60, 60, 30, 30, 0}, false, "FFFFFFFF"},
      {"held at zero alone", {0, 0, 0, 0, 0, 60, 0}, false, "FFFFFFF"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what, row.setpoints);
    CHECK(kinds_of(row.setpoints, row.pressed) == row.kinds);
  }
}

TEST_CASE("history kinds: each sweep is one history, repeats of another path are one, fitted inner paths none") {
  const std::vector<double> loop{0, 20, 40, 60, 40, 20, 0}, reversals{0, 60, 0, 50, 10, 40, 20, 55, 0};
  const Dataset calibration = dataset_of({along(loop)});
  const auto histories = [&](const Dataset& run, const Dataset& fitted) {
    const FrameErrors errors = frame_errors(run, straight_fit(), 1);
    std::vector<std::pair<UseCondition, std::size_t>> found;
    for (const KindHistories& one : kind_histories(run, errors, fitted, 0.0, 60.0))
      found.emplace_back(one.kind, one.history.frames.size());
    std::ranges::sort(found);
    return found;
  };
  using Found = std::vector<std::pair<UseCondition, std::size_t>>;
  const UseCondition sweep = UseCondition::kFullSweeps, whole = UseCondition::kReversals;
  CHECK(histories(dataset_of({along(loop, 3)}), calibration) == Found{{sweep, 7}, {sweep, 7}, {sweep, 7}});
  const Dataset twice = dataset_of({along(reversals, 2), along(reversals)});
  CHECK(histories(twice, calibration) == Found{{sweep, 3}, {sweep, 3}, {sweep, 3}, {whole, 6}, {whole, 12}});
  CHECK(histories(twice, twice) == Found{{sweep, 3}, {sweep, 3}, {sweep, 3}});
  // Full pressure in the sequence before, or in conditioning, which no command accounts for, counts for those after it.
  const std::vector<double> small{0, 20, 16, 20, 14, 18, 16, 20, 0};
  CHECK(histories(dataset_of({along(small)}), calibration).empty());
  CHECK(histories(dataset_of({along(loop), along(small)}), calibration).size() == 2);
  Dataset conditioned = dataset_of({along(small)});
  for (Sample& sample : conditioned.sequences[0].repeats[0].steps) sample.time_s = 30.0;
  CHECK(histories(conditioned, calibration).size() == 1);
}

TEST_CASE("arrival times: are those of the first frame at each level above the lowest") {
  Dataset run = dataset_of({along({0, 20, 20, 20, 40, 60})});
  std::vector<Sample>& steps = run.sequences[0].repeats[0].steps;
  steps[1].held_s = 1.0;
  steps[4].held_s = 2.0;
  steps[5].held_s = 4.0;
  const std::optional<ArrivalTimes> found = arrival_times(run);
  REQUIRE(found);
  CHECK((found->low_s == 1.0 && found->high_s == 4.0));
  for (Sample& sample : steps) sample.held_s = 0.0;
  CHECK_FALSE(arrival_times(run));
}

// Measuring intervals by hand.

namespace {

// Two taxels; up at 0, 10, ..., 50 psi, down at 0 and 10.
ConditionUncertainty stated() {
  ConditionUncertainty out;
  out.pressure_psi = {0, 10, 20, 30, 40, 50, 0, 10};
  out.up = {true, true, true, true, true, true, false, false};
  out.expanded_psi = {1, 1, 1, 2, 3, 1, 1, 1, 1, 1, 1, 1, 5, 5, 5, 5};
  out.error_psi.assign(16, 0.0);
  return out;
}

constexpr std::size_t kBothTaxels[] = {0, 1}, kFirst[] = {0};

}  // namespace

TEST_CASE("measuring interval: is the longest run of levels, from either end, a single one, or none") {
  const ConditionUncertainty known = stated();
  const auto of = [&](double mpe, bool up = true) { return measuring_interval(known, up, mpe, kBothTaxels); };
  // Level 20 has U of 3 psi of one taxel, level 10 of 2.
  CHECK((of(3.0).any && of(3.0).low_psi == 0.0 && of(3.0).high_psi == 50.0));
  CHECK((of(2.99).low_psi == 30.0 && of(2.99).high_psi == 50.0));
  CHECK((of(1.0).low_psi == 30.0 && of(1.0).high_psi == 50.0));
  CHECK_FALSE(of(0.99).any);
  CHECK_FALSE(of(4.99, false).any);
  CHECK((of(5.0, false).low_psi == 0.0 && of(5.0, false).high_psi == 10.0));
  CHECK_FALSE(measuring_interval({}, true, 9.0, kBothTaxels).any);
}

TEST_CASE("measuring interval: known error adds to U, a share of taxels suffices, taxels without U are outside") {
  ConditionUncertainty known = stated();
  known.error_psi[2 * 4] = -0.5;  // at 40 psi of the first taxel
  const MeasuringInterval both = measuring_interval(known, true, 1.4, kBothTaxels);
  CHECK((both.low_psi == 0.0 && both.high_psi == 0.0));  // of runs of equal length the lowest
  CHECK(measuring_interval(known, true, 1.5, kBothTaxels).low_psi == 30.0);
  CHECK(measuring_interval(known, true, 1.4, kFirst).high_psi == 10.0);
  const MeasuringInterval half = measuring_interval(known, true, 1.4, kBothTaxels, 0.5);
  CHECK((half.low_psi == 0.0 && half.high_psi == 50.0));
  known.expanded_psi[2 * 2] = known.expanded_psi[2 * 2 + 1] = kNan;  // at 20 psi
  const MeasuringInterval beside = measuring_interval(known, true, 9.0, kBothTaxels, 0.5);
  CHECK((beside.low_psi == 30.0 && beside.high_psi == 50.0));
}
