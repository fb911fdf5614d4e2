// Every figure of the rig from records made by hand: levels that were held, ramps on the way to them, presses.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/statistics/figures/rig_figures.h"

using namespace tactbench;
using namespace tactbench::analysis;

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
