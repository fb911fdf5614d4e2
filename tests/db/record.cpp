// Records read back as they were written; which scan of a frame the others contradict, and the mean of those that are
// left.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("run store: a run reads back as written") {
  NewStore store;
  db::RunRecord given = example_run();
  given.uuid = db::new_uuid();
  given.seed = std::numeric_limits<std::int64_t>::min();
  given.purpose = std::string("with a \0 inside and \xC3\xA4", 23);
  const Begun begun = begin_example(store, given);
  const db::RunRecord run = store.run(begun.run);
  CHECK(run.run == 1);
  CHECK(run.outcome == db::Outcome::kIncomplete);
  CHECK(run.safe_state == db::SafeState::kUnknown);
  CHECK(run.content_sha256.empty());
  CHECK(run.ended_utc.empty());
  const auto texts = [](const db::RunRecord& r) {
    return std::vector<std::string>{r.uuid,           r.origin,        r.state,           r.operator_name,
                                    r.purpose,        r.sensor_serial, r.scanner_serial,  r.bench_id,
                                    r.bench_toml,     r.bench_sha256,  r.sensor_toml,     r.sensor_sha256,
                                    r.overrides_json, r.host,          r.program_version, r.git_commit,
                                    r.build_id,       r.time_zone,     r.started_utc};
  };
  CHECK(texts(run) == texts(given));
  CHECK(run.git_dirty);
  CHECK(run.seed == given.seed);
  CHECK(run.sensor_seed == -8);
  REQUIRE(run.sequences.size() == 2);
  const db::SequenceRecord& down = run.sequences[1];
  CHECK((down.sequence == 1 && down.name == "down" && down.recipe_toml == "recipe b" && down.recipe_sha256 == "rb"));
  CHECK((down.repeats == 1 && down.frames_per_repeat == 4));
  REQUIRE(run.devices.size() == 2);
  const db::DeviceRecord& device = run.devices[1];
  CHECK((device.role == "tactile scanner" && device.model == "T-1" && device.serial == "SC-7"));
  CHECK((device.firmware == "2.0" && device.origin == "simulated"));
  CHECK(device.calibration_json == given.devices[1].calibration_json);
  CHECK(store.runs().size() == 1);
}

TEST_CASE("run store: frames, branches, checks and events read back exactly") {
  NewStore store;
  const Begun begun = begin_example(store);
  db::FrameRecord odd = example_frame(begun.branch, 1);
  odd.setpoint_psi = 5e-324;
  odd.feedback_psi = kNaN;  // no reading
  odd.reference_psi = std::nextafter(60.0, 61.0);
  odd.in_band_ns = -1;
  odd.wrench.reset();
  odd.trace.clear();
  odd.flags.clear();
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.append_frame(begun.run, odd);
  const std::vector<db::FrameRecord> frames = store.frames(begun.run);
  REQUIRE(frames.size() == 2);
  CHECK((store.frame_count(begun.run) == 2 && store.flagged_frame_count(begun.run) == 1));
  CHECK(store.scans_of_first_frame(begun.run) == 2);
  const db::FrameRecord given = example_frame(begun.branch, 0);
  const db::FrameRecord& got = frames[0];
  CHECK((got.branch == given.branch && got.ordinal == 0 && got.status == 4 && got.exchanges == 11));
  CHECK((got.setpoint_psi == given.setpoint_psi && got.feedback_psi == given.feedback_psi &&
         got.reference_psi == given.reference_psi));
  CHECK((got.setpoint_counts == 100 && got.feedback_counts == -200 && got.reference_counts == 300));
  CHECK((got.time_ns == given.time_ns && got.since_command_ns == given.since_command_ns &&
         got.in_band_ns == given.in_band_ns && got.device_time_us == given.device_time_us));
  CHECK((got.rows == 3 && got.columns == 2 && got.scans == 2));
  CHECK(got.counts == given.counts);
  CHECK(got.flags == "dwell");
  REQUIRE(got.trace.size() == 2);
  CHECK((got.trace[1].before_frame_s == 0.5F && got.trace[1].setpoint_psi == 2.1F &&
         got.trace[1].feedback_psi == 2.05F && got.trace[1].reference_psi == 2.06F));
  REQUIRE(got.wrench.has_value());
  CHECK((got.wrench->target_n == 6.1 && got.wrench->force_start_n == 6.3 && got.wrench->place_mm[2] == 40.3));
  CHECK((got.wrench->wrench == given.wrench->wrench && got.wrench->raw == given.wrench->raw));
  CHECK(frames[1].setpoint_psi == 5e-324);
  CHECK(std::isnan(frames[1].feedback_psi));
  CHECK(frames[1].reference_psi == odd.reference_psi);
  CHECK(frames[1].in_band_ns == -1);
  CHECK((!frames[1].wrench && frames[1].trace.empty() && frames[1].flags.empty()));

  store.void_branch(begun.branch, "why");
  const db::BranchRecord branch = store.branches(begun.run).at(0);
  CHECK((branch.branch == begun.branch && branch.sequence == 1 && branch.repeat == 0 && branch.ordinal == 0));
  CHECK((branch.is_void && branch.void_reason == "why" && branch.from_psi == 0.1 && branch.to_psi == 60.0));
  CHECK((branch.from_n == 2.1 && branch.to_n == 30.3));
  store.append_check(begun.run, {begun.run, 7, "warm-up", "warning", "{}", {0.1, kNaN}});
  const db::CheckRecord check = store.checks(begun.run).at(0);
  CHECK((check.time_ns == 7 && check.kind == "warm-up" && check.verdict == "warning" && check.data.at(0) == 0.1));
  store.set_rest(begun.run, 12.5);
  store.set_seen(begun.run, "2026-01-01T00:00:00Z");
  CHECK((store.run(begun.run).rest_s == 12.5 && store.run(begun.run).seen_utc == "2026-01-01T00:00:00Z"));
  store.append_event(begun.run, {-3, "note", "", "by hand"});
  store.set_state(begun.run, "running", {9, "state", "X", "go"});
  const std::vector<db::EventRecord> events = store.events(begun.run);
  REQUIRE(events.size() == 2);
  CHECK((events[0].time_ns == -3 && events[0].kind == "note" && events[0].detail == "by hand"));
  CHECK((events[1].time_ns == 9 && events[1].id == "X" && store.run(begun.run).state == "running"));
}

namespace {

using Counts = std::vector<std::uint16_t>;

// Of one taxel.
double mean_of(const Counts& scans, std::vector<double> before = {}) {
  return db::scan_means(scans, scans.size(), before).front();
}

}  // namespace

TEST_CASE("scans: a sample far from the majority of the others is left out of the mean") {
  CHECK(mean_of({5000, 5004}) == 5002.0);
  CHECK(mean_of({5000, 8200}) == 6600.0);  // within 5 % of the converter: noise, or a load that moves
  CHECK(mean_of({5000, 65535, 5004}) == 5002.0);
  CHECK(mean_of({0, 5000, 5004, 5008}) == 5004.0);
  CHECK(mean_of({30000, 5000, 5004}) == 5002.0);
  CHECK(mean_of({65535}) == 65535.0);                      // there is no other
  CHECK(mean_of({5000, 5000, 65535, 65535}) == 35267.5);   // no majority here either
  CHECK(mean_of({65535, 65535, 65535, 5000}) == 65535.0);  // the taxel is at the limit
}

TEST_CASE("scans: of two that differ, the one near the previous frame counts, else the one not at a limit") {
  CHECK(mean_of({5600, 65535}) == 5600.0);
  CHECK(mean_of({0, 5600}) == 5600.0);
  CHECK(mean_of({5600, 30000}) == 17800.0);
  CHECK(mean_of({5600, 30000}, {5000.0}) == 5600.0);
  CHECK(mean_of({65535, 61000}, {62000.0}) == 61000.0);
  CHECK(mean_of({5600, 30000}, {18000.0}) == 17800.0);  // as far from both
}

TEST_CASE("scans: means are per taxel, and a disagreement of any taxel is reported") {
  const Counts frame = {100, 200, 300, 104, 65535, 300};  // two scans of three taxels
  CHECK(db::scan_means(frame, 2) == std::vector<double>{102.0, 200.0, 300.0});
  CHECK(db::scans_disagree(frame, 2));
  CHECK_FALSE(db::scans_disagree(Counts{100, 200, 300, 104, 210, 300}, 2));
  CHECK_FALSE(db::scans_disagree(Counts{100, 200, 65535}, 1));
  CHECK(std::isnan(db::consensus_count(frame, 2, 0, {100.0, 100.0})));
  CHECK(db::consensus_count(frame, 2, 1, {100.0, 300.0}) == 200.0);
}

TEST_CASE("outcome and safe state: each converts to its text and back, and not from a text of the other") {
  using db::Outcome, db::SafeState;
  const std::vector<std::pair<Outcome, std::string>> outcomes = {
      {Outcome::kIncomplete, "incomplete"}, {Outcome::kCompleted, "completed"}, {Outcome::kStopped, "stopped"},
      {Outcome::kAborted, "aborted"},       {Outcome::kFailed, "failed"},       {Outcome::kInterrupted, "interrupted"}};
  for (const auto& [outcome, word] : outcomes) {
    CHECK(db::to_string(outcome) == word);
    CHECK(db::outcome_from(word) == outcome);
  }
  const std::vector<std::pair<SafeState, std::string>> states = {{SafeState::kUnknown, "unknown"},
                                                                 {SafeState::kVerified, "verified"},
                                                                 {SafeState::kUnverified, "unverified"},
                                                                 {SafeState::kFailed, "failed"}};
  for (const auto& [state, word] : states) {
    CHECK(db::to_string(state) == word);
    CHECK(db::safe_state_from(word) == state);
  }
  CHECK(!db::outcome_from("verified"));
  CHECK(!db::safe_state_from("completed"));
}

TEST_CASE("run store: the series of an imported run read back bit for bit") {
  NewStore store;
  db::RunRecord imported = example_run();
  imported.origin = "imported";
  const Begun begun = begin_example(store, imported);
  const std::vector<double> input = {0.0, 0.1, 1.0 / 3.0}, output = {-1e-300, 2.0 / 3.0, 1e300};
  store.append_series(begun.run, {{1, 0, input, output}, {0, 7, output, input}});
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 7, input, output}}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 8, input, {1.0}}}); }) == "TB-STORE-CONFLICT");
  store.end_run(begun.run, db::Outcome::kCompleted, "imported", db::SafeState::kUnknown, "");
  const std::vector<db::SeriesRecord> back = store.series(begun.run);
  REQUIRE(back.size() == 2);
  CHECK((back[0].sequence == 0 && back[0].taxel == 7 && back[0].input == output && back[0].output == input));
  CHECK((back[1].sequence == 1 && back[1].input == input && back[1].output == output));
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 9, input, output}}); }) == "TB-STORE-CONFLICT");
}
