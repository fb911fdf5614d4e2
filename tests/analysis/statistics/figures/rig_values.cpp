// Every figure of the rig from records made by hand: levels that were held, ramps on the way to them, presses; effects
// of time: creep, windows of pressure, dwells.

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <map>

#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/figures/rig_figures.h"
#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;
using namespace tactbench;

namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

struct RigHold {
  int repeat = 0;
  double setpoint_psi = 0.0;
  std::vector<double> reference_psi;  // a second apart
  double feedback_below = 0.0, settling_s = 0.0;
  std::vector<db::TracePoint> approach;
};

// A branch for each hold.
StoredRun run_holding(const std::vector<RigHold>& holds) {
  StoredRun run;
  std::int64_t time_ns = 0;
  for (const RigHold& hold : holds) {
    db::BranchRecord branch;
    branch.branch = static_cast<std::int64_t>(run.branches.size()) + 1;
    branch.repeat = hold.repeat;
    branch.ordinal = static_cast<int>(run.branches.size());
    for (std::size_t i = 0; i < hold.reference_psi.size(); ++i) {
      db::FrameRecord frame;
      frame.branch = branch.branch;
      frame.setpoint_psi = hold.setpoint_psi;
      frame.reference_psi = hold.reference_psi[i];
      frame.feedback_psi = hold.reference_psi[i] - hold.feedback_below;
      frame.time_ns = time_ns += 1'000'000'000;
      frame.in_band_ns = 500'000'000;
      frame.since_command_ns = frame.in_band_ns + std::llround(1e9 * (hold.settling_s + static_cast<double>(i)));
      if (i == 0) frame.trace = hold.approach;
      run.frames.push_back(frame);
    }
    run.branches.push_back(branch);
  }
  return run;
}

std::map<std::string, double> chamber_of_holds(const std::vector<RigHold>& holds) {
  return chamber_figures(run_holding(holds));
}

db::FrameRecord press_at(std::int64_t branch, double target_n, double start_n, double fz_n, double z_mm,
                         double x_mm = 0.0) {
  db::FrameRecord frame;
  frame.branch = branch;
  db::WrenchRecord wrench;
  wrench.target_n = target_n;
  wrench.force_start_n = start_n;
  wrench.wrench[2] = fz_n;
  wrench.place_mm = {x_mm, 0.0, z_mm};
  frame.wrench = wrench;
  return frame;
}

db::BranchRecord press_branch(std::int64_t number, int ordinal, double from_n, double to_n) {
  db::BranchRecord branch;
  branch.branch = number;
  branch.ordinal = ordinal;
  branch.from_n = from_n;
  branch.to_n = to_n;
  return branch;
}

}  // namespace

TEST_CASE("chamber values: zeros, offsets, settling, venting and repeatability match hand-computed values") {
  // The first hold of a repeat was not come to: it settles, repeats and overshoots nothing.
  const std::map<std::string, double> f = chamber_of_holds({{0, 0, {0.1, 0.3}, 0.05, 9.0, {}},
                                                            {0, 30, {30.2, 30.4}, -0.08, 1.0, {}},
                                                            {0, 60, {60.5}, 0.02, 2.0, {}},
                                                            {0, 30, {29.6}, 0.02, 4.0, {}},
                                                            {0, 0, {-0.2}, 0.06, 3.0, {}},
                                                            {1, 0, {0.6}, 0.06, 8.0, {}},
                                                            {1, 30, {30.7}, 0.02, 5.0, {}},
                                                            {1, 0, {0.2}, 0.04, 4.0, {}}});
  CHECK(f.at("zero_reference_psi") == Approx((0.2 - 0.2 + 0.6 + 0.2) / 4));
  CHECK(f.at("zero_feedback_psi") == Approx((0.15 - 0.26 + 0.54 + 0.16) / 4));
  CHECK(f.at("reference_minus_setpoint_psi") == Approx((0.3 + 0.5 - 0.4 + 0.7) / 4));
  CHECK(f.at("reference_minus_feedback_psi") == Approx(-0.08));  // the largest either way, with its sign
  CHECK(f.at("settling_s") == Approx((1.0 + 2.0 + 4.0 + 5.0) / 4));
  CHECK(f.at("venting_s") == Approx((3.0 + 4.0) / 2));
  // Rising to 30 psi 30.3 and 30.7; falling to 0 -0.2 and 0.2: 0.4 apart each. Down 29.6, up 30.5.
  CHECK(f.at("repeatability_psi") == Approx(0.4 / std::sqrt(2.0)));
  CHECK(f.at("regulator_hysteresis_psi") == Approx(29.6 - 30.5));
  CHECK(f.count("hold_drift_psi_per_min") == 0);  // no hold of four frames
  CHECK(f.count("hold_noise_psi") == 0);
  CHECK(f.count("ramp_lag_s") == 0);
  CHECK(f.count("overshoot_psi") == 0);
}

TEST_CASE("chamber values: drift and noise come from holds of at least four frames") {
  const std::vector<double> rising{20.0, 20.01, 20.02, 20.03}, noisy{40.1, 39.9, 39.9, 40.1}, short_one{30, 31, 35};
  const std::map<std::string, double> f =
      chamber_of_holds({{0, 20, rising, 0, 0, {}}, {0, 40, noisy, 0, 0, {}}, {0, 30, short_one, 0, 0, {}}});
  CHECK(f.at("hold_drift_psi_per_min") == Approx(0.6));
  CHECK(f.at("hold_noise_psi") == Approx(std::sqrt((0.0 + 0.01) / 2)));
  const std::vector<double> falling{20.0, 19.98, 19.96, 19.94, 19.92};
  CHECK(chamber_of_holds({{0, 20, falling, 0, 0, {}}, {0, 20.5, rising, 0, 0, {}}}).at("hold_drift_psi_per_min") ==
        Approx(-1.2));
}

TEST_CASE("chamber values: ramp lag counts up and down, without the first polls and the level itself") {
  using Points = std::vector<db::TracePoint>;
  // Seconds before the frame, set-point, feedback, reference.
  // Up by 10 psi/s: 1.5 and 2.5 psi behind are 0.15 and 0.25 s.
  const Points up{{0.6F, 4, 0, 0},    {0.5F, 5, 0, 0},    {0.4F, 6, 0, 0}, {0.3F, 7, 0, 0},
                  {0.2F, 8, 0, 6.5F}, {0.1F, 9, 0, 6.5F}, {0.0F, 10, 0, 0}};
  CHECK(chamber_of_holds({{0, 0, {0}, 0, 0, {}}, {0, 10, {10}, 0, 0, up}}).at("ramp_lag_s") ==
        Approx(0.2).epsilon(1e-5));
  // Down by 20 psi/s, 1 and 3 psi above: 0.05 and 0.15 s.
  // A poll at the same set-point, and one at the same time, tell nothing.
  const Points down{{0.6F, 50, 0, 0},  {0.6F, 50, 0, 0},  {0.6F, 50, 0, 0},  {0.6F, 50, 0, 0},
                    {0.5F, 48, 0, 49}, {0.4F, 48, 0, 40}, {0.4F, 46, 0, 40}, {0.3F, 44, 0, 47}};
  const std::map<std::string, double> f = chamber_of_holds({{0, 60, {60}, 0, 0, {}}, {0, 40, {40}, 0, 0, down}});
  CHECK(f.at("ramp_lag_s") == Approx(0.1).epsilon(1e-5));
  CHECK(chamber_of_holds({{0, 60, {60}, 0, 0, up}}).count("ramp_lag_s") == 0);  // the first: no way to it
}

TEST_CASE("chamber values: overshoot counts beyond the level in the direction of travel, not at zero") {
  using Points = std::vector<db::TracePoint>;
  const Points both{{0.2F, 10, 0, 9.0F}, {0.1F, 10, 0, 10.75F}};
  const auto overshoot = [&](double from, double to, const Points& points) {
    const auto f = chamber_of_holds({{0, from, {from}, 0, 0, points}, {0, to, {to + 0.25}, 0, 0, points}});
    return f.contains("overshoot_psi") ? f.at("overshoot_psi") : -1.0;
  };
  CHECK(overshoot(5, 10, both) == Approx(0.5));    // 10.75 beyond a reference of 10.25
  CHECK(overshoot(20, 10, both) == Approx(1.25));  // 9 below it
  CHECK(overshoot(20, 10, {{0.1F, 10, 0, 10.75F}}) == 0.0);
  CHECK(overshoot(20, 0, {{0.1F, 0, 0, -3.0F}}) == -1.0);
}

TEST_CASE("chamber values: void, press and unreferenced frames do not count, zeros alone give no values") {
  StoredRun run = run_holding(
      {{0, 0, {0.1}, 0, 0, {}}, {0, 30, {30.5, 99}, 0, 0, {}}, {0, 40, {45}, 0, 0, {}}, {0, 50, {55}, 0, 0, {}}});
  run.frames[2].reference_psi = kNotMeasured;
  run.branches[2].is_void = true;
  run.frames[4].wrench = db::WrenchRecord{};
  CHECK(chamber_figures(run).at("reference_minus_setpoint_psi") == Approx(0.5));
  CHECK(chamber_of_holds({{0, 0, {0.1}, 0, 0, {}}, {0, 0, {0.2}, 0, 0, {}}}).empty());
  CHECK(chamber_figures({}).empty());
}

TEST_CASE("press values: relaxation, stiffness and stage repeatability match hand-computed values") {
  StoredRun run;
  run.branches = {press_branch(1, 0, 0, 20), press_branch(2, 1, 20, 0), press_branch(3, 0, 0, 20),
                  press_branch(4, 2, 0, 20)};
  run.branches[3].is_void = true;
  // Up from 9 N at 40 mm to 18 N at 40.5 mm: 18 N/mm; again from 9.5 to 17.5 N over 0.4 mm: 20 N/mm.
  run.frames = {press_at(1, 10, 10, -9, 40.0),       press_at(1, 20, 20, -18, 40.5),    press_at(2, 10, 0, -8, 40.3),
                press_at(3, 10, 10, -9.5, 40.04),    press_at(3, 20, 25, -17.5, 40.44), press_at(4, 10, 10, -1, 90.0),
                press_at(3, 20, 25, -17.5, 40.44, 5)};
  const std::map<std::string, double> f = press_figures(run);
  CHECK(f.at("force_relaxation_percent") == Approx((10.0 + 10.0 + 5.0 + 30.0 + 30.0) / 5));
  CHECK(f.at("press_stiffness_n_per_mm") == Approx(19.0));
  // At 10 N 40 and 40.04 mm, at 20 N 40.5 and 40.44 mm: 40 and 60 um apart. Down, and at x = 5 mm, it was but once.
  CHECK(f.at("stage_repeatability_um") == Approx(60.0 / std::sqrt(2.0)));
  CHECK(f.count("force_zero_drift_n") == 0);
}

TEST_CASE("press values: a branch without penetration has no stiffness, and the largest tare drift counts") {
  StoredRun run;
  run.branches = {press_branch(1, 0, 0, 20), press_branch(2, 0, 20, 20)};
  run.frames = {press_at(1, 10, 0, -9, 40.0), press_at(1, 20, 0, -18, 40.0), press_at(2, 10, 0, -9, 40.0, 1),
                press_at(2, 20, 0, -18, 41.0, 1)};
  for (const char* json :
       {R"({"drift_fz_n":0.003})", R"({"drift_fz_n":-0.005})", R"({"drift_fz_n":0.004})", "[]", "{}"})
    run.checks.push_back({1, 0, "tare", "pass", json, {}});
  run.checks.push_back({1, 0, "mount", "pass", R"({"drift_fz_n":9})", {}});
  const std::map<std::string, double> f = press_figures(run);
  CHECK(f.count("press_stiffness_n_per_mm") == 0);
  CHECK(f.count("force_relaxation_percent") == 0);
  CHECK(f.count("stage_repeatability_um") == 0);
  CHECK(f.at("force_zero_drift_n") == -0.005);
}

// Creep of straight taxels in the budget, at each bound and in words: by hand.

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
  CHECK(effect.share(0, 30, true) == 0.0);
  effect.levels = {{.sequence = "hold", .pressure_psi = 20, .up = true, .share = {0.125, kNan}},
                   {.sequence = "hold", .pressure_psi = 40, .up = true, .share = {0.375, 0.5}}};
  struct Row {
    std::size_t taxel;
    double psi;
    bool up;
    double share;
  };
  const Row upward[] = {{0, 10, true, 0.125}, {0, 20, true, 0.125},   {0, 25, true, 0.1875}, {0, 40, true, 0.375},
                        {0, 50, true, 0.375}, {0, 25, false, 0.1875}, {1, 25, true, 0.5}};
  for (const auto& [taxel, psi, up, share] : upward) {
    CAPTURE(taxel, psi, up);
    CHECK(effect.share(taxel, psi, up) == share);
  }
  effect.levels.push_back({.sequence = "hold", .pressure_psi = 30, .up = false, .share = {0.75, kNan}});
  CHECK(effect.share(0, 25, false) == 0.75);
  CHECK(effect.share(0, 25, true) == 0.1875);
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

// Errors over histories and between dwell times, window by window, on straight taxels: by hand.

namespace {

const WindowErrors& window_of(const std::vector<WindowErrors>& windows, double pressure, bool up) {
  for (const WindowErrors& window : windows)
    if (window.pressure_psi == pressure && window.up == up) return window;
  throw std::runtime_error("no such window");
}

FrameHistory whole(const FrameErrors& run) {
  FrameHistory history{&run, {}};
  for (std::size_t i = 0; i < run.frames.size(); ++i) history.frames.push_back(i);
  return history;
}

std::vector<WindowErrors> pooled_of(const FrameErrors& one, const LevelCorrections& corrections = {}) {
  const FrameHistory history = whole(one);
  return pooled_errors({&history, 1}, straight_fit(), corrections);
}

// Full up, to 36 psi down, to 44 up and back to 0 down. The last frame but one at 30 psi is in no window.
const std::vector<double> kWandering{0, 20, 40, 60, 36, 44, 30, 0};

}  // namespace

TEST_CASE("frame errors: each frame is listed in time order with branch, direction and whether it is a full sweep") {
  const Dataset data =
      dataset_of({erring_way("a", kWandering, {{0, 1, 2, -3, 4, 5, 6, 1}}), erring_way("b", {0, 20, 0}, {{0, 7, 0}})});
  const FrameErrors errors = frame_errors(data, straight_fit(), 1);
  CHECK(errors.run == 2);
  REQUIRE(errors.frames.size() == 11);
  std::string shape;
  for (const FrameErrors::Frame& frame : errors.frames)
    shape += std::to_string(frame.branch) + (frame.up ? (frame.full ? "U " : "u ") : (frame.full ? "D " : "d "));
  CHECK(shape == "0U 0U 0U 0U 1d 2u 3d 3d 0u 0u 1d ");
  CHECK((errors.frames[9].sequence == 1 && errors.frames[9].step == 1 && errors.frames[9].setpoint_psi == 20.0));
  CHECK(errors.error_psi[3 * 4] == Approx(4.0));
  CHECK(errors.error_psi[3 * 5 + 1] == Approx(2.5));
  CHECK(errors.error_psi[3 * 9] == Approx(7.0));
  CHECK(std::isnan(errors.error_psi[2]));
}

TEST_CASE("error windows: cover 4 psi to each side including the edge, with frame counts and mean squares") {
  const FrameErrors all =
      frame_errors(dataset_of({erring_way("a", {0, 15.9, 16, 24, 24.1, 60}, {{0, 9, 1, 3, 9, 0}, {0, 9, 5, 3, 9, 0}})}),
                   straight_fit(), 1);
  CHECK(all.frames.size() == 2 * 6);
  const std::vector<WindowErrors> errors = pooled_of(all);
  REQUIRE(errors.size() == 8);
  CHECK(has_any_branch(errors));
  const WindowErrors& twenty = window_of(errors, 20, true);
  CHECK(twenty.frames == 4.0);    // 15.9 and 24.1 are in no window
  CHECK(twenty.branches == 1.0);  // the repeats go the same way
  CHECK(twenty.square_psi[0] == Approx((1.0 + 9.0 + 25.0 + 9.0) / 4));
  CHECK(twenty.square_psi[1] == Approx(11.0 / 4));
  CHECK(std::isnan(twenty.square_psi[2]));
  // The two taxels' mean errs by 3/4 of the first.
  CHECK(twenty.common_square_psi == Approx(11.0 * 0.5625));
  const WindowErrors& down = window_of(errors, 20, false);
  CHECK((down.frames == 0.0 && down.branches == 0.0));
  CHECK((std::isnan(down.square_psi[0]) && std::isnan(down.common_square_psi)));
  CHECK_FALSE(has_any_branch(pooled_errors({}, straight_fit())));
}

TEST_CASE("error windows: branches, sequences and runs add up, one run can be left out, errors can be corrected") {
  const Dataset data = dataset_of(
      {erring_way("a", {0, 20, 40, 20, 40, 0}, {{0, 1, 2, 1, 3, 0}}), erring_way("b", {0, 20, 0}, {{0, 5, 0}})});
  const FrameErrors run = frame_errors(data, straight_fit(), 1);
  const WindowErrors once = window_of(pooled_of(run), 20, true);
  CHECK((once.frames == 2.0 && once.branches == 2.0));  // the ways of a and of b
  const WindowErrors twice = window_of(pooled_of(run), 40, true);
  CHECK((twice.frames == 2.0 && twice.branches == 2.0));  // both of a
  const FrameErrors second = run;
  const std::vector<FrameHistory> histories{whole(run), whole(second)};
  const std::vector<WindowErrors> both = pooled_errors(histories, straight_fit());
  CHECK((window_of(both, 20, true).frames == 4.0 && window_of(both, 20, true).branches == 4.0));
  CHECK(window_of(pooled_errors(histories, straight_fit(), {}, 0), 20, true).frames == 2.0);
  // 0.5 psi less at 20 psi up of the first taxel: errors of 0.5 and 4.5.
  LevelCorrections corrections(2 * 4 * 3, 0.0);
  corrections[1 * 3] = 0.5;
  const WindowErrors less = window_of(pooled_of(run, corrections), 20, true);
  CHECK(less.square_psi[0] == Approx((0.25 + 20.25) / 2));
  CHECK(less.square_psi[1] == Approx((0.25 + 6.25) / 2));
}

TEST_CASE("corrections: are linear between levels of one direction, constant beyond, and 0 if there is none") {
  const SensorModel fit = straight_fit();
  CHECK(correction_at({}, fit, 0, 30.0, true) == 0.0);
  // Of the first and the second taxel at 0, 20, 40 and 60 psi, up and then down.
  LevelCorrections corrections{1, 10, 0, 2, 20, 0, 6, 60, 0, -2, kNan, 0, -1, 0, 0, -5, 0, 0, -7, 0, 0, -9, 0, 0};
  struct Row {
    double psi;
    bool up;
    std::size_t taxel;
    double correction;
  };
  const Row rows[] = {{-3, true, 0, 1},   {0, true, 0, 1},   {5, true, 0, 1.25}, {20, true, 0, 2},   {30, true, 0, 4},
                      {55, true, 0, 0},   {60, true, 0, -2}, {61, true, 0, -2},  {kNan, true, 0, 1}, {5, false, 0, -2},
                      {61, false, 0, -9}, {30, true, 1, 40}, {50, true, 1, 30},  {61, true, 1, 0}};
  for (const auto& [psi, up, taxel, correction] : rows) {  // 50 psi of the second: half way to one that is not known
    CAPTURE(psi, up, taxel);
    CHECK(correction_at(corrections, fit, taxel, psi, up) == correction);
  }
}

namespace {

const std::vector<double> kPacedLoop{0, 16, 20, 24, 60, 40, 0};

DwellEffect dwell_of(const Dataset& paced, double usual_s) {
  const Dataset calibration = dataset_of({erring_way("loop", {0, 20, 60}, {{0, 0, 0}}, {usual_s})});
  const Dataset* runs[] = {&paced};
  return dwell_effect_of(calibration, runs, straight_fit(), 1);
}

Dataset paced_at_dwells(const std::vector<double>& dwell_s) {
  std::vector<std::vector<double>> errors(dwell_s.size(), std::vector<double>(7, 0.0));
  return dataset_of({erring_way("rate", kPacedLoop, errors, dwell_s)});
}

}  // namespace

TEST_CASE("dwell effect: is the largest mean square of the repeats against the one with the nearest dwell") {
  // Dwell times of 1, 3 and 8 s; the calibration's 2 s are nearer to 3 s by factor. Against that the repeats differ by
  // (1, 2, 3) and (-2, -2, 0) psi at 16, 20, 24 psi upward: mean squares 14/3 and 8/3; at 40 psi downward by 0 and 1.
  const Dataset paced = dataset_of({erring_way(
      "rate", kPacedLoop, {{0, 1.5, 2.5, 3.5, 0, 0, 0}, {0, 0.5, 0.5, 0.5, 0, 0, 0}, {0, -1.5, -1.5, 0.5, 0, 1, 0}},
      {1, 3, 8})});
  const DwellEffect effect = dwell_of(paced, 2.0);
  REQUIRE(effect.assessed());
  CHECK(effect.run == 2);
  CHECK(effect.low_s == 1.0);
  CHECK(effect.high_s == 8.0);
  REQUIRE(effect.square_psi.size() == 2 * 4 * 3);
  const auto square = [&](std::size_t level, bool up, std::size_t taxel) {
    return effect.square_psi[((up ? 0 : 4) + level) * 3 + taxel];
  };
  CHECK(square(1, true, 0) == Approx(14.0 / 3));
  CHECK(square(1, true, 1) == Approx(14.0 / 12));
  CHECK(std::isnan(square(1, true, 2)));
  CHECK(square(3, true, 0) == Approx(0.0).margin(1e-12));
  CHECK(square(2, false, 0) == Approx(1.0));
  CHECK(std::isnan(square(2, true, 0)));   // no step within 4 psi of 40 psi on the way up
  CHECK(std::isnan(square(1, false, 0)));  // nor of 20 psi on the way down
  // 1.7 s are 1.7 times as long as 1 s and 1.76 times as short as 3 s, 5 s 1.6 and 1.67 times as 8 s and 3 s: the first
  // and the last repeat lie furthest apart.
  for (const auto& [usual_s, largest] : {std::pair{1.7, 34.0}, {1.8, 14.0}, {4.8, 14.0}, {5.0, 34.0}})
    CHECK(dwell_of(paced, usual_s).square_psi[3] == Approx(largest / 3));
}

TEST_CASE("dwell effect: dwells must differ by a factor of two, and each of at least two repeats must state one") {
  struct Row {
    std::vector<double> dwell_s;
    double usual_s;
    bool assessed;
  };
  const Row rows[] = {
      {{1, 2}, 1, true}, {{1, 1.99}, 1, false}, {{4}, 1, false}, {{1, 4, 0}, 1, false}, {{1, 4}, 0, false}};
  for (const Row& row : rows) CHECK(dwell_of(paced_at_dwells(row.dwell_s), row.usual_s).assessed() == row.assessed);
  CHECK_FALSE(dwell_of(paced_at_dwells({4}), 1.0).not_assessed.empty());
  // The first run, and in it the first sequence, that tells.
  Dataset first = paced_at_dwells({1, 1}), second = paced_at_dwells({1, 4}), third = paced_at_dwells({1, 9});
  second.sequences.insert(second.sequences.begin(), first.sequences.front());
  second.run = 8;
  const Dataset* runs[] = {&first, &second, &third};
  const DwellEffect effect = dwell_effect_of(second, runs, straight_fit(), 1);
  CHECK(effect.run == 8);
  CHECK(effect.high_s == 4.0);
}

TEST_CASE("median dwell: is the median over repeats of their medians, above 0.5 psi, where stated") {
  Dataset data = dataset_of({erring_way("a", {0, 0.5, 0.51, 20, 40}, {{0, 0, 0, 0, 0}}, {1})});
  std::vector<Sample>& steps = data.sequences[0].repeats[0].steps;
  for (std::size_t i = 0; i < 5; ++i) steps[i].held_s = 100.0 / static_cast<double>(i + 1);  // 100 50 33.3 25 20
  CHECK(median_dwell_s(data) == Approx(25.0));
  steps[4].held_s = 0.0;
  CHECK(median_dwell_s(data) == Approx((100.0 / 3 + 25.0) / 2));
  data.sequences.push_back(erring_way("b", {20, 40}, {{0, 0}, {0, 0}}, {7, 9}));
  CHECK(median_dwell_s(data) == 9.0);  // of 29.2, 7 and 9
  CHECK(std::isnan(median_dwell_s(dataset_of({erring_way("c", {0, 0.5}, {{0, 0}}, {3})}))));
}
