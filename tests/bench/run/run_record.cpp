// The row of a run: what of the request is stored, which devices a continued run must find again, what can be read back
// of an old one.

#include "bench/run/run_record.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <stdexcept>
#include <string>
#include <vector>

#include "bench/common/build_info.h"
#include "bench/common/error.h"
#include "bench/common/utc.h"
#include "bench/run/recorder.h"
#include "bench/run/resume.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "tests/bench/run/quick_store.h"
#include "tests/db/store_example.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using bench::Recorder;
using bench::RunState;
using bench::StepReadings;
using std::chrono::milliseconds;

namespace {

struct KeptRow {
  QuickStore store;
  KeptRow() { store.add_sensor(example_sensor()); }
};

db::DeviceRecord device(const std::string& role, const std::string& model, const std::string& serial) {
  return {role, model, serial, "1", "simulated", "{}"};
}

std::string kept_fault_id(const std::function<void()>& act) {
  const auto fault = devices::fault_of(act);
  if (!fault) return "";
  CHECK_FALSE(as_error(std::make_exception_ptr(*fault)).remedy().empty());
  return fault->id();
}

}  // namespace

TEST_CASE("run record: every member of the request is stored") {
  RunRequest request = small_request({{"simulation.seed", "7"}}, {11, 12});
  request.overrides.push_back({"recipe.note", "a \"b\""});
  request.recipes.push_back(recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\nrepeats = 3\n"));
  request.purpose = "why";
  request.operator_name = "who";
  const db::RunRecord row = record_of(request);
  CHECK(row.uuid.size() == 36);
  CHECK(row.state == "prepared");
  CHECK(row.origin == "simulated");
  CHECK(row.operator_name == "who");
  CHECK(row.purpose == "why");
  CHECK(row.sensor_serial == "S-1");
  CHECK(row.scanner_serial == "SIM-SCANNER-1");
  CHECK(row.bench_id == "simulated-rig");
  CHECK(row.bench_toml == request.bench.text);
  CHECK(row.bench_sha256 == db::sha256_hex(request.bench.text));
  CHECK(row.sensor_toml == request.sensor_type.text);
  CHECK(row.sensor_sha256 == db::sha256_hex(request.sensor_type.text));
  CHECK(row.overrides_json == R"([{"key":"simulation.seed","value":"7"},{"key":"recipe.note","value":"a \"b\""}])");
  CHECK(row.seed == 11);
  CHECK(row.sensor_seed == 12);
  CHECK(row.program_version == build_info().version);
  CHECK(row.git_commit == build_info().commit);
  CHECK(row.git_dirty == build_info().modified);
  CHECK(row.build_id == build_info().build);
  CHECK_FALSE(row.host.empty());
  CHECK_FALSE(row.time_zone.empty());
  CHECK(row.started_utc.size() == 20);
  REQUIRE(row.sequences.size() == 2);
  CHECK((row.sequences[0].sequence == 0 && row.sequences[1].sequence == 1));
  CHECK((row.sequences[0].repeats == 2 && row.sequences[1].repeats == 3));
  CHECK((row.sequences[0].frames_per_repeat == 15 && row.sequences[1].frames_per_repeat == 2));
  CHECK(row.sequences[1].name == "small");
  CHECK(row.sequences[1].recipe_toml == request.recipes[1].text);
  CHECK(row.sequences[1].recipe_sha256 == db::sha256_hex(request.recipes[1].text));
  request.bench.origin = devices::Origin::kHardware;
  request.bench.simulation.reset();
  CHECK(record_of(request).origin == "hardware");
  CHECK((record_of(request).seed == 0 && record_of(request).sensor_seed == 0));
}

TEST_CASE("run record: stored overrides are read back, invalid text gives none") {
  const auto read = stored_overrides(R"([{"key":"a.b","value":"1"},{"key":"c","value":""}])");
  REQUIRE(read);
  REQUIRE(read->size() == 2);
  CHECK(((*read)[0].key == "a.b" && (*read)[0].value == "1" && (*read)[1].key == "c" && (*read)[1].value.empty()));
  CHECK(stored_overrides("[]").value().empty());
  for (const char* strange : {"", "{}", "7", R"([{"key":"a"}])", R"([{"value":"a"}])", R"([{"key":1,"value":"a"}])",
                              R"([{"key":"a","value":1}])", "[7]"}) {
    INFO(strange);
    CHECK_FALSE(stored_overrides(strange));
  }
}

TEST_CASE("run record: a stored bench is read with its overrides, without those of recipes") {
  RunRequest request = small_request({{"limits.trip_psi", "64"}});
  request.overrides.push_back({"recipe.dwell_s", "9"});
  db::RunRecord row = record_of(request);
  row.run = 5;
  REQUIRE(stored_bench(row));
  CHECK(stored_bench(row)->limits.trip_psi == 64.0);
  CHECK_THAT(stored_bench(row)->file, Catch::EndsWith(" 5"));
  row.overrides_json = "{";
  CHECK_FALSE(stored_bench(row));
  row.overrides_json = R"([{"key":"no.such.key","value":"1"}])";
  CHECK_FALSE(stored_bench(row));
  row.overrides_json = "[]";
  row.bench_toml = "schema = 99\n";
  CHECK_FALSE(stored_bench(row));
}

TEST_CASE("run record: a sensor with another number of taxels than the scanner is rejected") {
  RunRequest request = small_request();
  CHECK_NOTHROW(check_geometry(request));
  const auto refused = [&](int rows, int columns) {
    request.sensor_type.rows = rows;
    request.sensor_type.columns = columns;
    try {
      check_geometry(request);
    } catch (const Error& error) {
      CHECK(error.code() == ExitCode::kUsage);
      CHECK_FALSE(error.remedy().empty());
      CHECK_THAT(error.what(), Catch::Contains(fmt::format("{} x {}", rows, columns)) && Catch::Contains("16 x 16"));
      return error.id();
    }
    return std::string("none");
  };
  CHECK(refused(16, 8) == "TB-SENSOR-GEOMETRY");
  CHECK(refused(8, 16) == "TB-SENSOR-GEOMETRY");
  CHECK(refused(16, 16) == "none");
}

TEST_CASE("run record: devices are stored once, and a continued run must find each of them again") {
  KeptRow row;
  db::RunRecord run = example_run();
  run.devices.clear();
  const std::int64_t number = row.store.begin_run(run);
  const std::vector<db::DeviceRecord> begun = {device("regulator", "R", "1"), device("scanner", "S", "2")};
  keep_devices(row.store, number, begun);
  REQUIRE(row.store.run(number).devices.size() == 2);
  CHECK(row.store.run(number).devices[1].serial == "2");
  CHECK(kept_fault_id([&] {
          keep_devices(row.store, number, {begun[1], begun[0], device("stage", "Z", "3")});
        }).empty());
  CHECK(row.store.run(number).devices.size() == 2);
  const auto missing = [&](const db::DeviceRecord& in_place) {
    return kept_fault_id([&] { keep_devices(row.store, number, {begun[0], in_place}); });
  };
  CHECK(missing(device("scanner", "S", "3")) == "TB-RESUME-DEVICES");
  CHECK(missing(device("scanner", "T", "2")) == "TB-RESUME-DEVICES");
  CHECK(missing(device("array", "S", "2")) == "TB-RESUME-DEVICES");
  CHECK(missing({"scanner", "S", "2", "6", "hardware", "{1}"}).empty());  // firmware and calibration may be others
  CHECK(missing(begun[1]).empty());
}

TEST_CASE("run record: a device that reports an invalid name is rejected") {
  KeptRow row;
  db::RunRecord run = example_run();
  run.devices.clear();
  const std::int64_t number = row.store.begin_run(run);
  const auto kept = [&](const std::string& model) {
    return kept_fault_id([&] { keep_devices(row.store, number, {device("scanner", model, "1")}); });
  };
  CHECK(kept(std::string(100'000, 'x')) == "TB-DEVICE-NAME");
  CHECK(kept("a\xff") == "TB-DEVICE-NAME");
}

TEST_CASE("run record: the rest of a sensor starts at the last sign of activity of its newest earlier run") {
  KeptRow row;
  db::SensorRecord other = example_sensor();
  other.serial = "S-2";
  row.store.add_sensor(other);
  const auto seconds_ago = [](int seconds) {
    const std::time_t then = std::time(nullptr) - seconds;
    std::tm utc{};
    gmtime_r(&then, &utc);
    char text[32] = {};
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return std::string(text);
  };
  const auto add = [&](const std::string& serial, int started, int seen, int ended) {
    db::RunRecord run = example_run();
    run.uuid.clear();
    run.sensor_serial = serial;
    run.started_utc = seconds_ago(started);
    const std::int64_t number = row.store.begin_run(run);
    if (seen > 0) row.store.set_seen(number, seconds_ago(seen));
    if (ended > 0) row.store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, seconds_ago(ended));
    return number;
  };
  const std::int64_t first = add("S-1", 9000, 8000, 7000);
  CHECK_FALSE(rest_of_sensor(row.store, "S-1", first));
  const std::int64_t others = add("S-2", 300, 200, 100);
  CHECK(rest_of_sensor(row.store, "S-1", others + 1).value() == Approx(7000.0).margin(30.0));
  const std::int64_t second = add("S-1", 5000, 4000, 0);
  CHECK(rest_of_sensor(row.store, "S-1", second).value() == Approx(7000.0).margin(30.0));
  CHECK(rest_of_sensor(row.store, "S-1", second + 1).value() == Approx(4000.0).margin(30.0));
  (void)add("S-1", 3000, 0, 0);
  CHECK(rest_of_sensor(row.store, "S-1", second + 9).value() == Approx(3000.0).margin(30.0));
  CHECK_FALSE(rest_of_sensor(row.store, "S-3", second + 9));
}

// The rows written by the recorder, field by field, into a store without a rig.

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
