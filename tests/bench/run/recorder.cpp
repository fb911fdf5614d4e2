// The rows written by the recorder, field by field, into a store without a rig.
#include "bench/run/recorder.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "bench/common/utc.h"
#include "bench/run/resume.h"
#include "bench/run/run_record.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Recorder;
using bench::RunState;
using bench::StepReadings;
using std::chrono::milliseconds;

namespace {

struct Records {
  Records() {
    request = small_request();
    store.add_sensor(request.sensor);
    run = store.begin_run(bench::record_of(request));
  }
  QuickStore store;
  bench::RunRequest request;
  std::int64_t run = 0;
  devices::ManualClock clock;
};

sequences::Step step_of(int branch, int ordinal, double psi) {
  sequences::Step step;
  step.repeat = 1;
  step.branch = branch;
  step.ordinal = ordinal;
  step.setpoint = devices::Psi(psi);
  step.branch_from = devices::Psi(2.0);
  step.branch_to = devices::Psi(8.0);
  return step;
}

devices::PressureReading pressure_of(double psi, std::int32_t counts) {
  return {devices::Psi(psi), devices::Volts(0.0), counts, {}};
}

StepReadings readings_at(devices::Nanoseconds time) {
  StepReadings readings;
  readings.setpoint_counts = 11;
  readings.feedback = pressure_of(5.5, 22);
  readings.reference = pressure_of(5.25, 33);
  readings.scans = {1, 2, 1, {7, 8}, {1}, 99, 3, time};
  readings.commanded_at = time - milliseconds(2500);
  readings.in_band_since = time - milliseconds(2000);
  readings.exchanges = 12;
  readings.flags = "dwell";
  return readings;
}

}  // namespace

TEST_CASE(
    "recorder: a frame row has every field, times with the offset of the run, and readings since the last frame") {
  Records records;
  Recorder recorder(records.store, records.run, records.clock, milliseconds(100'000));
  recorder.open_branch(step_of(2, 4, 6.0));
  records.clock.wait_until(milliseconds(1000));
  recorder.poll(devices::Psi(6.0), pressure_of(5.0, 1), pressure_of(4.5, 1));
  records.clock.wait_until(milliseconds(1500));
  recorder.poll(devices::Psi(6.5), pressure_of(5.5, 1), pressure_of(5.25, 1));
  recorder.frame(step_of(2, 4, 6.0), readings_at(milliseconds(3000)));
  StepReadings busy = readings_at(milliseconds(4000));
  busy.exchanges = 20;
  recorder.frame(step_of(2, 5, 8.0), busy);
  recorder.frame(step_of(2, 6, 8.0), readings_at(milliseconds(5000)));
  CHECK(recorder.frames() == 3);
  CHECK(recorder.max_exchanges() == 20);
  CHECK(recorder.store_seconds() > 0.0);
  CHECK(recorder.store_seconds() < 60.0);
  const std::vector<db::FrameRecord> frames = records.store.frames(records.run);
  REQUIRE(frames.size() == 3);
  const db::FrameRecord& frame = frames[0];
  CHECK(frame.ordinal == 4);
  CHECK(frame.setpoint_psi == 6.0);
  CHECK(frame.feedback_psi == 5.5);
  CHECK(frame.reference_psi == 5.25);
  CHECK((frame.setpoint_counts == 11 && frame.feedback_counts == 22 && frame.reference_counts == 33));
  CHECK(frame.time_ns == 103'000'000'000);
  CHECK(frame.since_command_ns == 2'500'000'000);
  CHECK(frame.in_band_ns == 2'000'000'000);
  CHECK((frame.device_time_us == 99 && frame.status == 3 && frame.exchanges == 12));
  CHECK((frame.rows == 1 && frame.columns == 2 && frame.scans == 1));
  CHECK(frame.counts == std::vector<std::uint16_t>{7, 8});
  CHECK(frame.flags == "dwell");
  CHECK_FALSE(frame.wrench);
  REQUIRE(frame.trace.size() == 2);
  CHECK(frame.trace[0].before_frame_s == 2.0F);
  CHECK(frame.trace[1].before_frame_s == 1.5F);
  CHECK(frame.trace[1].setpoint_psi == 6.5F);
  CHECK(frame.trace[1].feedback_psi == 5.5F);
  CHECK(frame.trace[1].reference_psi == 5.25F);
  CHECK(frames[1].trace.empty());
}

TEST_CASE("recorder: branches with attempts, voids and repeats, including those of an earlier process") {
  Records records;
  {
    Recorder recorder(records.store, records.run, records.clock);
    recorder.void_branch("none is open");
    recorder.open_branch(step_of(0, 0, 2.0));
    recorder.void_branch("broken");
    recorder.void_branch("twice");
    recorder.open_branch(step_of(0, 0, 2.0));
    recorder.close_branch();
    recorder.void_branch("closed");
    recorder.open_branch(step_of(1, 0, 2.0));
  }
  Recorder later(records.store, records.run, records.clock);
  later.open_branch(step_of(0, 0, 2.0));
  sequences::Step press = step_of(3, 0, 0.0);
  press.kind = sequences::StepKind::kPress;
  press.force_from_n = 2.0;
  press.force_to_n = 30.0;
  press.repeat = 2;
  later.open_branch(press);
  std::vector<db::BranchRecord> branches = records.store.branches(records.run);
  REQUIRE(branches.size() == 5);
  CHECK((branches[0].attempt == 0 && branches[0].is_void && branches[0].void_reason == "broken"));
  CHECK((branches[1].attempt == 1 && !branches[1].is_void));
  CHECK((branches[2].attempt == 0 && branches[2].ordinal == 1));
  CHECK(branches[3].attempt == 2);
  CHECK((branches[0].repeat == 1 && branches[0].from_psi == 2.0 && branches[0].to_psi == 8.0));
  CHECK_FALSE(branches[0].from_n);
  CHECK(branches[4].from_n == 2.0);
  CHECK(branches[4].to_n == 30.0);
  CHECK_FALSE(records.store.run(records.run).seen_utc.empty());
  later.void_repeat(0, 1, "rested");
  branches = records.store.branches(records.run);
  CHECK(branches[0].void_reason == "broken");
  for (const std::size_t i : {1U, 2U, 3U}) CHECK(branches[i].void_reason == "rested");
  CHECK_FALSE(branches[4].is_void);
  later.void_repeat(1, 2, "another sequence");
  CHECK_FALSE(records.store.branches(records.run)[4].is_void);
}

TEST_CASE("recorder: events, checks and states have run times, a forbidden state change is rejected") {
  Records records;
  Recorder recorder(records.store, records.run, records.clock, milliseconds(5000));
  records.clock.wait_until(milliseconds(20));
  recorder.event("kind", "TB-X", "detail");
  recorder.check("mount", "pass", "{}", {1.5, 2.5});
  CHECK_THROWS_AS(recorder.state(RunState::kPaused, "x"), std::logic_error);
  recorder.state(RunState::kRunning, "devices open");
  CHECK(recorder.state() == RunState::kRunning);
  CHECK(recorder.run() == records.run);
  CHECK(records.store.run(records.run).state == "running");
  const auto events = records.store.events(records.run);
  REQUIRE(events.size() == 2);
  CHECK((events[0].time_ns == 5'020'000'000 && events[0].kind == "kind" && events[0].id == "TB-X"));
  CHECK_THAT(events[1].detail, Catch::StartsWith("prepared -> running") && Catch::EndsWith("devices open"));
  const auto checks = records.store.checks(records.run);
  REQUIRE(checks.size() == 1);
  CHECK((checks[0].time_ns == 5'020'000'000 && checks[0].kind == "mount" && checks[0].data[1] == 2.5));
}

TEST_CASE("reopened runs: rest and time continue from the end, and only a longer rest restarts the repeat") {
  for (const double rest_s : {1e12, 0.0}) {
    Records records;
    records.request.recipes[0].rest_restart_s = rest_s;
    const auto steps = sequences::compile(records.request.recipes);
    Recorder recorder(records.store, records.run, records.clock);
    int whole = 0;  // frames of the first branch and half of the second
    for (const sequences::Step& step : steps) {
      if (!has_frame(step) || step.branch > 1) continue;
      if (step.branch == 1 && ++whole > 2) break;
      if (step.ordinal == 0 || (step.branch == 1 && whole == 1)) recorder.open_branch(step);
      StepReadings readings = readings_at(milliseconds(1000 + 1000 * step.ordinal));
      recorder.frame(step, readings);
    }
    records.store.end_run(records.run, db::Outcome::kStopped, "why", db::SafeState::kVerified, "2020-01-01T00:00:00Z");
    const double since = bench::seconds_between("2020-01-01T00:00:00Z", bench::utc_now());
    const bench::ResumePoint point = bench::reopen(records.store, records.run, records.request.recipes, steps);
    CHECK(point.rest_s == Approx(since).margin(60.0).epsilon(0.0));
    CHECK(devices::in_seconds(point.offset) ==
          Approx(devices::in_seconds(devices::Nanoseconds(records.store.frames(records.run).back().time_ns)) +
                 point.rest_s)
              .margin(1.0)
              .epsilon(0.0));
    CHECK(point.had_ended == "stopped: why");
    const auto branches = records.store.branches(records.run);
    REQUIRE(branches.size() == 2);
    CHECK(branches[1].is_void);
    CHECK(branches[0].is_void == (rest_s == 0.0));
    CHECK(point.voided == (rest_s == 0.0 ? 2 : 1));
    CHECK(point.done.size() == (rest_s == 0.0 ? 0U : 1U));
    CHECK(records.store.run(records.run).state == "prepared");
  }
}
