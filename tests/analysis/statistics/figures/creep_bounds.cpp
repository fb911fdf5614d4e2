// Creep of straight taxels in the budget, at each bound and in words: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

// A level that is read once, `after_s` after its command.
Dataset read_once(double after_s, double psi = 40.0) {
  Repeat repeat;
  for (const double level : {0.0, psi}) {
    repeat.steps.push_back({level, level, level, after_s});
    repeat.volts.insert(repeat.volts.end(), {0, 0, 9});
  }
  return dataset_of({{"loop", {repeat}}});
}

// Frames `step_s` apart at a level, from `from_s` after its command on; the first taxel's outputs are given, the
// second's rise by half as much of its own output.
struct HoldOf {
  double psi = 40.0, from_s = 2.0, step_s = 2.0;
  std::vector<double> first_v;
  double before_psi = 0.0, reference_end_psi = 40.0;
};
Dataset held_once(const HoldOf& hold) {
  Repeat repeat;
  repeat.steps.push_back({hold.before_psi, hold.before_psi, 0.0, 1.0});
  repeat.volts = {0, 0, 9};
  const std::size_t n = hold.first_v.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double reference = i + 5 >= n ? hold.reference_end_psi : hold.psi;
    repeat.steps.push_back({hold.psi, reference, 100.0 + hold.step_s * static_cast<double>(i), hold.from_s});
    const double risen = hold.first_v[i] / hold.first_v[0] - 1.0;
    repeat.volts.insert(repeat.volts.end(), {hold.first_v[i], hold.psi / 10.0 * (1.0 + 0.5 * risen), 9});
  }
  return dataset_of({{"creep-hold", {repeat}}});
}

// 2 V at first, then `end_v` at the last five frames, in between `middle_v`.
std::vector<double> steps_to(double end_v, std::size_t frames = 20, double middle_v = 2.0) {
  std::vector<double> volts(frames, middle_v);
  volts[0] = 2.0;
  for (std::size_t i = frames - 5; i < frames; ++i) volts[i] = end_v;
  return volts;
}

CreepEffect straight_effect(const std::vector<Dataset>& runs, double after_s = 2.0) {
  return creep_effect_of(read_once(after_s), runs, straight_fit());
}

}  // namespace

TEST_CASE("creep effect: is the mean of the last five frames over the output at the calibration's time") {
  std::vector<double> volts = steps_to(2.1);
  volts[14] = 7.0;  // the sixth from the end does not count
  const CreepEffect effect = straight_effect({held_once({.first_v = volts})});
  REQUIRE(effect.assessed());
  REQUIRE(effect.levels.size() == 1);
  CHECK(effect.levels[0].share[0] == Approx(0.05));
  CHECK(effect.levels[0].share[1] == Approx(0.025));
  CHECK(std::isnan(effect.levels[0].share[2]));
  CHECK(effect.levels[0].median_share == Approx(0.0375));
  CHECK((effect.levels[0].from_s == 2.0 && effect.levels[0].to_s == 40.0));
  CHECK((effect.to_s == 40.0 && effect.read_after_s == 2.0 && !effect.extrapolated_back && !effect.undone));
  // A fall counts by its size.
  CHECK(straight_effect({held_once({.first_v = steps_to(1.9)})}).levels[0].share[0] == Approx(0.05));
}

TEST_CASE("creep effect: is interpolated between frames, and corrected for a reference that moves") {
  // 2 V at 2 s and 2.2 V from 4 s on: 2.05 V at 2.5 s.
  const CreepEffect between = straight_effect({held_once({.first_v = steps_to(2.2, 20, 2.2)})}, 2.5);
  CHECK(between.levels[0].share[0] == Approx(0.15 / 2.05));
  // The reference ends 0.5 psi higher: 25 mV of the first taxel, 50 mV of the second one.
  const CreepEffect moved = straight_effect({held_once({.first_v = steps_to(2.1), .reference_end_psi = 40.5})});
  CHECK(moved.levels[0].share[0] == Approx(0.075 / 2.0));
  CHECK(moved.levels[0].share[1] == Approx(0.05 / 4.0));
}

TEST_CASE("creep effect: a hold must last twice the dwell, start before half its end, and be in the models' range") {
  // Twenty frames from 2 s to 40 s.
  CHECK(straight_effect({held_once({.first_v = steps_to(2.1)})}, 20.0).assessed());
  CHECK_FALSE(straight_effect({held_once({.first_v = steps_to(2.1)})}, 20.1).not_assessed.empty());
  // From 38 s to 76 s, and from 39 s to 77 s.
  CHECK(straight_effect({held_once({.from_s = 38.0, .first_v = steps_to(2.1)})}).assessed());
  CHECK_FALSE(straight_effect({held_once({.from_s = 39.0, .first_v = steps_to(2.1)})}).assessed());
  const auto at = [](double psi) {
    return straight_effect({held_once({.psi = psi, .first_v = steps_to(2.1), .reference_end_psi = psi})}).assessed();
  };
  CHECK(at(60.0));
  CHECK(at(60.0 + 5e-7));
  CHECK_FALSE(at(60.0 + 2e-6));
  // A late one is carried back along the logarithm: of 4 to 42 s to 2 to 42 s.
  const CreepEffect late = straight_effect({held_once({.from_s = 4.0, .first_v = steps_to(2.1)})});
  CHECK(late.extrapolated_back);
  CHECK(late.levels[0].share[0] == Approx(0.05 * std::log(21.0) / std::log(10.5)));
}

TEST_CASE("creep effect: two holds of one level and branch give the larger share, the later start and earlier end") {
  const Dataset long_one = held_once({.first_v = steps_to(2.1, 30)}),
                later = held_once({.from_s = 3.0, .first_v = steps_to(2.2)});
  const CreepEffect both = straight_effect({long_one, later});
  REQUIRE(both.levels.size() == 1);
  CHECK(both.levels[0].share[0] == Approx(0.1 * std::log(20.5) / std::log(41.0 / 3.0)));
  CHECK((both.levels[0].from_s == 3.0 && both.levels[0].to_s == 41.0));
  CHECK(both.to_s == 41.0);
  // From above it is another branch; levels stand by branch, then by pressure.
  const CreepEffect branches =
      straight_effect({held_once({.first_v = steps_to(2.2), .before_psi = 60.0}), long_one,
                       held_once({.psi = 20.0, .first_v = steps_to(2.1), .reference_end_psi = 20.0})});
  REQUIRE(branches.levels.size() == 3);
  CHECK((branches.levels[0].up && branches.levels[0].pressure_psi == 20.0));
  CHECK((branches.levels[1].up && branches.levels[1].pressure_psi == 40.0));
  CHECK((!branches.levels[2].up && branches.levels[2].pressure_psi == 40.0));
  CHECK_THAT(branches.display_text(), Catch::Contains("40.0 psi"));
}

TEST_CASE("creep effect: over several levels the earliest end and the latest start count") {
  const Dataset short_one = held_once({.first_v = steps_to(2.1)}),
                long_one = held_once({.psi = 20.0, .first_v = steps_to(2.1, 30), .reference_end_psi = 20.0}),
                late = held_once({.psi = 30.0, .from_s = 3.0, .first_v = steps_to(2.1), .reference_end_psi = 30.0});
  for (const auto& runs : {std::vector{short_one, long_one}, std::vector{long_one, short_one}}) {
    const CreepEffect effect = straight_effect(runs);
    CHECK(effect.levels.size() == 2);
    CHECK(effect.to_s == 40.0);
    CHECK_FALSE(effect.extrapolated_back);
  }
  CHECK(straight_effect({short_one, late}).extrapolated_back);
  CHECK(straight_effect({late, short_one}).extrapolated_back);
}

TEST_CASE("creep share: is linear between held levels, constant beyond, and from the other branch if missing") {
  CreepEffect effect;
  const auto level = [&](double psi, bool up, double first, double second) {
    HeldLevel held;
    held.pressure_psi = psi;
    held.up = up;
    held.share = {first, second};
    effect.levels.push_back(held);
  };
  CHECK(effect.share(0, 30, true) == 0.0);
  level(20, true, 0.1, kNan);
  level(40, true, 0.3, 0.5);
  CHECK(effect.share(0, 10, true) == 0.1);
  CHECK(effect.share(0, 20, true) == 0.1);
  CHECK(effect.share(0, 25, true) == Approx(0.15));
  CHECK(effect.share(0, 40, true) == 0.3);
  CHECK(effect.share(0, 50, true) == 0.3);
  CHECK(effect.share(0, 25, false) == Approx(0.15));
  CHECK(effect.share(1, 25, true) == 0.5);
  level(30, false, 0.7, kNan);
  CHECK(effect.share(0, 25, false) == 0.7);
  CHECK(effect.share(0, 25, true) == Approx(0.15));
  CHECK(effect.share(1, 25, false) == 0.0);
}

TEST_CASE("creep effect: the calibration's dwell is from sequences without holds, above 0.5 psi, if stated") {
  Dataset calibration = read_once(3.0);
  const Dataset hold = held_once({.from_s = 9.0, .first_v = steps_to(2.1)});
  calibration.sequences.push_back(hold.sequences.front());
  const std::vector<Dataset> runs{held_once({.first_v = steps_to(2.1)})};
  CHECK(creep_effect_of(calibration, runs, straight_fit()).read_after_s == 3.0);
  CHECK(straight_effect(runs, 3.0).read_after_s == 3.0);
  Dataset low = read_once(3.0, 0.5);
  CHECK_FALSE(creep_effect_of(low, runs, straight_fit()).not_assessed.empty());
  low = read_once(3.0, 0.51);
  CHECK(creep_effect_of(low, runs, straight_fit()).read_after_s == 3.0);
  // No hold, holds of too few frames, and those of a run that does not tell its times.
  for (const std::size_t frames : {2U, 3U, 19U})
    CHECK_FALSE(straight_effect({held_once({.first_v = std::vector<double>(frames, 2.0)})}).assessed());
  CHECK(straight_effect({}).display_text().empty());
  const CreepEffect timeless = straight_effect(runs, 0.0);
  CHECK((!timeless.assessed() && !timeless.not_assessed.empty()));
  Dataset other = runs.front();
  other.sensor_serial = "S2";
  CHECK_THROWS_AS(straight_effect({other}), AnalysisError);
}
