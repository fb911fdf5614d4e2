// The differences that check_content names, and that it notices every changed byte of content.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "db/sqlite.h"
#include "tests/db/new_store.h"
#include "tests/support/sanitized.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

// All canonical content of a run, as read back, bit for bit.
std::string content_read_back(const RunStore& store, std::int64_t number) {
  std::string text;
  const auto word = [&](const std::string& value) { text += fmt::format("{}:{};", value.size(), value); };
  const auto whole = [&](auto... values) { ((text += fmt::format("{};", values)), ...); };
  const auto real = [&](double value) { text += fmt::format("{:x};", std::bit_cast<std::uint64_t>(value)); };
  const auto reals = [&](const auto& values) {
    whole(values.size());
    for (const double value : values) real(value);
  };
  const db::RunRecord r = store.run(number);
  for (const std::string* value :
       {&r.origin, &r.reason, &r.operator_name, &r.purpose, &r.sensor_serial, &r.scanner_serial, &r.bench_id,
        &r.bench_toml, &r.bench_sha256, &r.sensor_toml, &r.sensor_sha256, &r.overrides_json, &r.program_version,
        &r.git_commit, &r.build_id}) {
    word(*value);
  }
  word(db::to_string(r.outcome));
  word(db::to_string(r.safe_state));
  whole(r.git_dirty, r.seed, r.sensor_seed, r.sequences.size(), r.devices.size());
  for (const db::SequenceRecord& s : r.sequences) {
    for (const std::string* value : {&s.name, &s.recipe_toml, &s.recipe_sha256}) word(*value);
    whole(s.sequence, s.repeats, s.frames_per_repeat);
  }
  for (const db::DeviceRecord& d : r.devices) {
    for (const std::string* value : {&d.role, &d.model, &d.serial, &d.firmware, &d.origin, &d.calibration_json}) {
      word(*value);
    }
  }
  const std::vector<db::BranchRecord> branches = store.branches(number);
  for (const db::BranchRecord& b : branches) {
    whole(b.sequence, b.repeat, b.ordinal, b.attempt, b.is_void, b.from_n.has_value(), b.to_n.has_value());
    word(b.void_reason);
    for (const double value : {b.from_psi, b.to_psi, b.from_n.value_or(0.0), b.to_n.value_or(0.0)}) real(value);
  }
  for (const db::FrameRecord& f : store.frames(number)) {
    std::size_t branch = 0;
    while (branch < branches.size() && branches[branch].branch != f.branch) ++branch;
    whole(branch, f.ordinal, f.setpoint_counts, f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns,
          f.in_band_ns, f.device_time_us, f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts.size());
    for (const double value : {f.setpoint_psi, f.feedback_psi, f.reference_psi}) real(value);
    for (const std::uint16_t count : f.counts) whole(count);
    word(f.flags);
    for (const db::TracePoint& p : f.trace) {
      reals(std::array<double, 4>{p.before_frame_s, p.setpoint_psi, p.feedback_psi, p.reference_psi});
    }
    if (!f.wrench) continue;
    real(f.wrench->target_n);
    real(f.wrench->force_start_n);
    reals(f.wrench->wrench);
    reals(f.wrench->raw);
    reals(f.wrench->place_mm);
  }
  for (const db::EventRecord& e : store.events(number)) {
    whole(e.time_ns);
    for (const std::string* value : {&e.kind, &e.id, &e.detail}) word(*value);
  }
  for (const db::CheckRecord& c : store.checks(number)) {
    whole(c.time_ns);
    for (const std::string* value : {&c.kind, &c.verdict, &c.detail_json}) word(*value);
    reals(c.data);
  }
  for (const db::SeriesRecord& s : store.series(number)) {
    whole(s.sequence, s.taxel);
    reals(s.input);
    reals(s.output);
  }
  return text;
}

// A run of many frames, so that most of the file is content.
std::int64_t store_long_example(RunStore& store) {
  const Begun begun = begin_example(store);
  store.set_state(begun.run, "running", {5, "state", "", "prepared -> running"});
  for (int i = 0; i < 100; ++i) {
    db::FrameRecord frame = example_frame(begun.branch, i);
    frame.rows = 12;
    frame.columns = 12;
    frame.counts.clear();
    for (int k = 0; k < 2 * 144; ++k) frame.counts.push_back(static_cast<std::uint16_t>(977 * k + 31 * i));
    store.append_frame(begun.run, frame);
  }
  store.append_check(begun.run, {begun.run, 4, "seating", "pass", R"({"rows":3})", {1.0 / 3.0, 2.5}});
  store.append_series(begun.run, {{0, 3, {0.5, 1.5}, {2.5, 3.5}}});
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "2024-05-01T10:00:00Z");
  return begun.run;
}

void remove_store(const std::string& path) {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path + ending);
}

std::string changed(RunStore& store, std::int64_t run, const std::string& sql) {
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON; BEGIN; " + sql + "; COMMIT");
  return store.check_content(run).difference;
}

}  // namespace

TEST_CASE("the first thing that differs is named") {
  const auto named = [](const std::string& sql) {
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    db::RunRecord record = example_run();
    for (db::SequenceRecord& sequence : record.sequences) {
      sequence.recipe_sha256 = db::sha256_hex(sequence.recipe_toml);
    }
    const std::int64_t run = store_example(store, record);
    return changed(store, run, sql);
  };
  using Catch::Contains;
  CHECK_THAT(named("UPDATE frames SET reference_psi = 7 WHERE frame % 10 = 2"),
             Contains("frame 2 (sequence 1 'down', repeat 0, branch 0, attempt 1, step 0): its row"));
  CHECK_THAT(named("UPDATE frames SET status = 7 WHERE frame % 10 > 1"), Contains("frame 2 "));
  CHECK_THAT(named("UPDATE branches SET ordinal = 9 WHERE attempt = 1"), Contains("frame 2 ") && Contains("branch 9"));
  CHECK_THAT(named("UPDATE frames SET branch = 77 WHERE frame % 10 = 3"), Contains("frame 3 (of no branch"));
  CHECK_THAT(named("DELETE FROM frames WHERE frame % 10 = 2"), Contains("frame 2 is missing"));
  CHECK_THAT(named("UPDATE frames SET status = 7 WHERE frame % 10 = 1"), Contains("run's row") && Contains("frame 1"));
  CHECK_THAT(named("UPDATE runs SET operator = 'X'"), Contains("run's row"));
  CHECK_THAT(named("UPDATE devices SET serial = 'X'"), Contains("a device"));
  CHECK_THAT(named("UPDATE sequences SET recipe_toml = 'X' WHERE sequence = 1"),
             Contains("recipe of sequence 1 ('down')"));
  CHECK_THAT(named("UPDATE runs SET bench_toml = 'X'"), Contains("bench file"));
  CHECK_THAT(named("UPDATE runs SET sensor_toml = 'X'"), Contains("sensor file"));
  CHECK_THAT(named("UPDATE events SET detail = 'X' WHERE id <> ''"), Contains("what follows") && Contains("an event"));
  CHECK_THAT(named("DELETE FROM frames WHERE frame % 10 = 3"), Contains("number of frames (now 2)"));
  CHECK_THAT(named("UPDATE runs SET outcome = 'stopped'"), Contains("outcome"));
  CHECK_THAT(named("UPDATE runs SET content_sha256 = replace(content_sha256, substr(content_sha256, 9, 1), 'x')"),
             Contains("stored hash itself"));
  CHECK_THAT(named("UPDATE runs SET content_sha256 = ''"), Contains("stored hash itself"));
  CHECK_THAT(named("UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 2"),
             Contains("link") && Contains("frame 2"));
  CHECK_THAT(named("UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 3"),
             Contains("link") && Contains("frame 3"));
  CHECK(named("UPDATE runs SET host = 'X', tags = 'a', notes = 'b', started_utc = 'c', time_zone = 'd'").empty());
}

TEST_CASE("one changed byte anywhere in the file is noticed, or the content reads back as it was") {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  {
    RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    run = store_long_example(store);
  }
  REQUIRE_FALSE(std::filesystem::exists(folder.path("runs.db-wal")));
  const std::string whole = read_file(folder.path("runs.db"));
  const std::string content = content_read_back(RunStore::open_read_only(folder.path("runs.db")), run);
  REQUIRE(content.size() > 30000);
  std::mt19937_64 random(20240501);
  constexpr int kFlips = kSanitized ? 300 : 1000;
  int refused = 0, red = 0, harmless = 0;
  const std::string path = folder.path("copy.db");
  for (int i = 0; i < kFlips; ++i) {
    std::string bytes = whole;
    const std::size_t place = random() % bytes.size();
    const auto flip = static_cast<unsigned char>(i % 2 == 0 ? 1U << (random() % 8) : 1 + random() % 255);
    bytes[place] = static_cast<char>(static_cast<unsigned char>(bytes[place]) ^ flip);
    write_file(path, bytes);
    std::string read_back;
    bool holds = false, opened = false;
    try {
      const RunStore store = RunStore::open_read_only(path);
      holds = store.check_content(run).holds();
      opened = true;
      if (holds) read_back = content_read_back(store, run);
    } catch (const db::StoreError&) {
      holds = false;
    }
    ++(!opened ? refused : !holds ? red : harmless);
    if (holds && read_back != content) {
      FAIL_CHECK("byte " << place << " changed by " << int{flip} << " (flip " << i << ") got past");
    }
    remove_store(path);
  }
  CAPTURE(refused, red, harmless);
  CHECK(refused + red + harmless == kFlips);
  CHECK(red > kFlips / 5);         // the file is mostly content: many flips must be noticed
  CHECK(harmless > kFlips / 100);  // and verify does not report bytes outside the content
}
