// A small run for tests of the store: every field filled, all with different values, doubles that have no short
// decimal.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/process.h"

namespace tactbench::tests {

inline constexpr const char* kUtc = "2026-01-01T00:00:00Z";

inline db::SensorRecord example_sensor() {
  return {"S-1", "array-3x2", "rows = 3\n", db::sha256_hex("rows = 3\n"), "SC-7", "first", "2024-05-01T08:00:00Z"};
}

inline db::RunRecord example_run() {
  db::RunRecord run;
  run.origin = "simulated";
  run.state = "prepared";
  run.operator_name = "N. Nobody";
  run.purpose = "test \"of\" the store\n";
  run.sensor_serial = "S-1";
  run.scanner_serial = "SC-7";
  run.bench_id = "bench-a";
  run.bench_toml = "id = \"bench-a\"\n";
  run.bench_sha256 = db::sha256_hex(run.bench_toml);
  run.sensor_toml = "rows = 3\n";
  run.sensor_sha256 = db::sha256_hex(run.sensor_toml);
  run.overrides_json = R"([{"key":"a","value":"1"}])";
  run.program_version = "0.1.0";
  run.git_commit = "0123abc";
  run.git_dirty = true;
  run.build_id = "Release, GNU";
  run.host = "host-a";
  run.time_zone = "CET";
  run.seed = 7;
  run.sensor_seed = -8;
  run.started_utc = "2024-05-01T09:00:00Z";
  run.sequences = {{0, "up", "recipe a", "ra", 2, 3}, {1, "down", "recipe b", "rb", 1, 4}};
  run.devices = {{"regulator", "R-1", "0001", "1.0", "simulated", R"({"span":1})"},
                 {"tactile scanner", "T-1", "SC-7", "2.0", "simulated", R"({"volts_per_count":0.1})"}};
  return run;
}

inline db::BranchRecord example_branch() {
  db::BranchRecord branch;
  branch.sequence = 1;
  branch.from_psi = 0.1;
  branch.to_psi = 60.0;
  branch.from_n = 2.1;
  branch.to_n = 30.3;
  return branch;
}

inline db::FrameRecord example_frame(std::int64_t branch, int ordinal) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.ordinal = ordinal;
  frame.setpoint_psi = 2.0 * ordinal;
  frame.feedback_psi = 2.0 * ordinal + 0.1;
  frame.reference_psi = 1.0 / (3.0 + ordinal);
  frame.setpoint_counts = 100 + ordinal;
  frame.feedback_counts = -200 - ordinal;
  frame.reference_counts = 300 + ordinal;
  frame.time_ns = 2'000'000'000'000 + ordinal;
  frame.since_command_ns = 2'000'000'001;
  frame.in_band_ns = 1'500'000'002;
  frame.device_time_us = 5'000'000'000'003;
  frame.status = 4;
  frame.exchanges = 11;
  frame.rows = 3;
  frame.columns = 2;
  frame.scans = 2;
  for (int i = 0; i < 12; ++i) frame.counts.push_back(static_cast<std::uint16_t>(65535 - 257 * i - ordinal));
  frame.flags = "dwell";
  frame.trace = {{1.5F, 2.0F, 1.9F, 1.8F}, {0.5F, 2.1F, 2.05F, 2.06F}};
  frame.wrench = db::WrenchRecord{
      6.1, 6.3, {0.1, 0.2, -6.2, 1.5, 2.5, 3.5}, {11, 12, 13, 14, 15, 16.5}, {20.1, 30.2, 40.3 + ordinal}};
  return frame;
}

// Registers the sensor, begins the run and its branch.
struct Begun {
  std::int64_t run = 0, branch = 0;
};
inline Begun begin_example(db::RunStore& store, const db::RunRecord& run = example_run()) {
  store.add_sensor(example_sensor());
  Begun begun;
  begun.run = store.begin_run(run);
  begun.branch = store.begin_branch(begun.run, example_branch());
  return begun;
}

// A whole run: three frames, one voided branch, two events.
inline std::int64_t store_example(db::RunStore& store, const db::RunRecord& run = example_run()) {
  const Begun begun = begin_example(store, run);
  store.set_state(begun.run, "running", {5, "state", "", "prepared -> running"});
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.void_branch(begun.branch, "scanner lost");
  db::BranchRecord again = example_branch();
  again.attempt = 1;
  const std::int64_t second = store.begin_branch(begun.run, again);
  store.append_frame(begun.run, example_frame(second, 0));
  store.append_frame(begun.run, example_frame(second, 1));
  store.append_check(begun.run, {begun.run, 4, "seating", "pass", R"({"rows":3})", {1.0 / 3.0, 2.5}});
  store.append_series(begun.run, {{0, 3, {0.5, 1.5}, {2.5, 3.5}}});
  store.append_event(begun.run, {6, "fault", "TB-SCANNER-SILENT", "no report"});
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "2024-05-01T10:00:00Z");
  return begun.run;
}

// The identifier of the StoreError that `action` throws; empty when it throws none.
template <class Action>
std::string store_error(Action action, std::string* message = nullptr) {
  try {
    action();
  } catch (const db::StoreError& error) {
    if (message != nullptr) *message = std::string(error.what()) + " | " + error.remedy();
    return error.id();
  }
  return {};
}

// A new store for a test, and processes next to the test's own.

// A new store in a folder that is removed with it.
class NewStore : TemporaryFolder, public db::RunStore {
 public:
  NewStore() : RunStore(open(TemporaryFolder::path("runs.db"))) {}
  using RunStore::path;
};

// The exit code of `action` in a separate process.
template <class Action>
int in_child(Action action) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(action());
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace tactbench::tests
