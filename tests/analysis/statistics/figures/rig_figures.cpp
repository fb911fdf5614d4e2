// Figures of the rig from runs whose pressures and places are known by construction.
#include "analysis/statistics/figures/rig_figures.h"

#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::map<std::string, double> chamber_of(const db::RunStore& store, std::int64_t run) {
  return analysis::chamber_figures(analysis::read_run(store, store.run(run)));
}

std::map<std::string, double> press_of(const db::RunStore& store, std::int64_t run) {
  return analysis::press_figures(analysis::read_run(store, store.run(run)));
}

struct LevelHeld {
  double setpoint = 0.0, reference = 0.0, slope_per_s = 0.0, settling_s = 0.0;
  int branch = 0;
};

// Five frames a level, 2 s apart; the feedback is always 0.02 psi below the reference, and the reference `offset`
// higher.
void hold(db::RunStore& store, std::int64_t run, int repeat, const std::vector<LevelHeld>& levels, double offset,
          double& time_s) {
  std::int64_t branch = 0;
  int ordinal = -1;
  for (const LevelHeld& level : levels) {
    if (level.branch != ordinal) {
      db::BranchRecord record;
      record.repeat = repeat;
      record.ordinal = ordinal = level.branch;
      branch = store.begin_branch(run, record);
    }
    for (int i = 0; i < 5; ++i) {
      db::FrameRecord frame = example_frame(branch, i);
      frame.wrench.reset();
      frame.flags.clear();
      frame.trace.clear();
      frame.setpoint_psi = level.setpoint;
      frame.reference_psi = level.reference + offset + level.slope_per_s * 2.0 * (i - 2);
      frame.feedback_psi = frame.reference_psi - 0.02;
      frame.time_ns = static_cast<std::int64_t>((time_s += 2.0) * 1e9);
      frame.in_band_ns = 1'000'000'000 + 2'000'000'000LL * i;
      frame.since_command_ns = frame.in_band_ns + static_cast<std::int64_t>(level.settling_s * 1e9);
      if (i == 0) frame.trace = {{0.2F, 60.0F, 1.0F, 60.5F}};
      store.append_frame(run, frame);
    }
  }
}

}  // namespace

TEST_CASE("the chamber's figures are those that the run was made with") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::RunRecord record = example_run();
  record.sequences = {{0, "rig-check", "r", "h", 2, 20}};
  store.add_sensor(example_sensor());
  const std::int64_t run = store.begin_run(record);
  const std::vector<LevelHeld> levels = {
      {0.0, 0.01, 0.0, 0.0, 0}, {60.0, 60.10, 0.001, 1.5, 0}, {30.0, 30.30, 0.0, 0.5, 1}, {0.0, 0.01, 0.0, 3.0, 1}};
  double time_s = 0.0;
  hold(store, run, 0, levels, 0.0, time_s);
  hold(store, run, 1, levels, 0.02, time_s);
  const std::map<std::string, double> figures = chamber_of(store, run);
  CHECK(figures.at("zero_reference_psi") == Approx(0.02));
  CHECK(figures.at("zero_feedback_psi") == Approx(0.0).margin(1e-12));
  CHECK(figures.at("reference_minus_feedback_psi") == Approx(0.02));
  CHECK(figures.at("reference_minus_setpoint_psi") == Approx(0.5 * (0.10 + 0.30) + 0.01));
  CHECK(figures.at("repeatability_psi") == Approx(0.02 / std::sqrt(2.0)));
  CHECK(figures.at("hold_drift_psi_per_min") == Approx(0.06));
  CHECK(figures.at("hold_noise_psi") == Approx(0.0).margin(1e-9));
  CHECK(figures.at("settling_s") == Approx(1.0));
  CHECK(figures.at("venting_s") == Approx(3.0));
  CHECK(figures.at("overshoot_psi") == Approx(0.40).margin(1e-5));
  CHECK(figures.count("regulator_hysteresis_psi") == 0);  // no level was held both ways
  CHECK(press_of(store, run).empty());
}

TEST_CASE("void branches do not count, and the regulator's hysteresis is what both ways differ by") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::RunRecord record = example_run();
  record.sequences = {{0, "rig-check", "r", "h", 1, 20}};
  store.add_sensor(example_sensor());
  const std::int64_t run = store.begin_run(record);
  double time_s = 0.0;
  hold(store, run, 0,
       {{0.0, 0.0, 0.0, 0.0, 0},
        {30.0, 30.1, 0.0, 0.5, 0},
        {60.0, 60.1, 0.0, 0.5, 0},
        {30.0, 30.35, 0.0, 0.5, 1},
        {0.0, 0.0, 0.0, 0.5, 1}},
       0.0, time_s);
  CHECK(chamber_of(store, run).at("regulator_hysteresis_psi") == Approx(0.25));
  CHECK(chamber_of(store, run).count("repeatability_psi") == 0);
  for (const db::BranchRecord& branch : store.branches(run)) store.void_branch(branch.branch, "redone");
  CHECK(chamber_of(store, run).empty());
}

TEST_CASE("the stage's repeatability is the spread of the places at one force, the zero's drift the tares'") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  for (int repeat = 0; repeat < 2; ++repeat) {
    db::BranchRecord branch = example_branch();
    branch.repeat = repeat;
    branch.ordinal = 1;
    branch.from_n = 0.0;
    branch.to_n = 20.0;
    const std::int64_t number = store.begin_branch(begun.run, branch);
    for (int i = 0; i < 2; ++i) {
      db::FrameRecord frame = example_frame(number, i);
      frame.wrench->target_n = 10.0 * (i + 1);
      frame.wrench->force_start_n = 10.0 * (i + 1);
      frame.wrench->wrench[2] = -9.5 * (i + 1);
      frame.wrench->place_mm = {30.0, 30.0, 40.0 + 0.5 * i + 0.01 * repeat * (i + 1)};
      store.append_frame(begun.run, frame);
    }
    store.append_check(begun.run,
                       {begun.run,
                        1,
                        "tare",
                        "pass",
                        repeat == 0 ? R"({"removed_fz_n":0.1})" : R"({"removed_fz_n":0.1,"drift_fz_n":-0.004})",
                        {}});
  }
  const std::map<std::string, double> figures = press_of(store, begun.run);
  CHECK(figures.at("stage_repeatability_um") == Approx(20.0 / std::sqrt(2.0)));
  CHECK(figures.at("force_relaxation_percent") == Approx(5.0));
  CHECK(figures.at("press_stiffness_n_per_mm") == Approx(0.5 * (9.5 / 0.5 + 9.5 / 0.51)));
  CHECK(figures.at("force_zero_drift_n") == Approx(-0.004));
  CHECK(chamber_of(store, begun.run).empty());
}
