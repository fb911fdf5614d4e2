// What is found in a store and how it is checked: frames as a second process follows them, runs and checks by
// conditions, and differences from what was stored.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using Catch::Contains;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;
using Numbers = std::vector<std::int64_t>;
using Positions = std::vector<std::int64_t>;

TEST_CASE("structure check: deleted runs and baselines are reported") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.begin_run(example_run());
  store.replace_figures(run, "rig/a", {{"x_psi", 1.0}});
  store.add_baseline({0, "rig/a", "as delivered", "K. Lee", kUtc, {run}});
  CHECK(store.check_structure().empty());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("DELETE FROM baseline_runs; DELETE FROM baselines");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Catch::StartsWith("baselines: 1 "));
  raw.execute(
      "PRAGMA foreign_keys = OFF; DELETE FROM seals WHERE run = 2; DELETE FROM sequences WHERE run = 2; "
      "DELETE FROM devices WHERE run = 2; DELETE FROM runs WHERE run = 2");
  CHECK_THAT(store.check_structure().front(), Catch::StartsWith("runs: 2 "));
}

TEST_CASE("content check: a frame without a branch of its run is named and still enters the hash") {
  for (const char* branch : {"-1", "2", "77"}) {
    CAPTURE(branch);
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    const Begun begun = begin_example(store), other = begin_example(store);  // branches 1 and 2
    db::BranchRecord next = example_branch();
    next.attempt = 1;
    const std::int64_t third = store.begin_branch(begun.run, next);
    REQUIRE((begun.branch == 1 && other.branch == 2 && third == 3));
    store.append_frame(begun.run, example_frame(begun.branch, 0));
    store.append_frame(begun.run, example_frame(third, 1));
    store.append_frame(begun.run, example_frame(third, 2));
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    const std::string before = store.content_hash(begun.run);
    Connection(store.path(), Access::kReadWrite)
        .execute("PRAGMA foreign_keys = OFF; UPDATE frames SET branch = " + std::string(branch) +
                 " WHERE frame % 10 = 2");
    const db::ContentCheck check = store.check_content(begun.run);
    CHECK_THAT(check.difference, Contains("frame 2 "));
    CHECK(check.computed_sha256 == store.content_hash(begun.run));
    CHECK(check.computed_sha256 != before);
    // As if it were of a branch 0 of sequence 0, which nothing else says of it.
    db::HashChain chain;
    db::Digest link = chain.header(store.run(begun.run));
    const auto branches = store.branches(begun.run);
    link = chain.frame(link, branches[0], example_frame(1, 0));
    link = chain.frame(link, {}, example_frame(0, 1));
    link = chain.frame(link, branches[1], example_frame(3, 2));
    db::RunEnd end;
    end.branches = branches;
    end.outcome = db::Outcome::kCompleted;
    end.safe = db::SafeState::kVerified;
    CHECK(db::hex(chain.close(link, 3, end)) == check.computed_sha256);
  }
}

TEST_CASE("content check: frames restored after pruning are reported, with the date of the pruning") {
  NewStore store;
  store_example(store);
  store_example(store);
  store.set_tags(2, {"nightly"}, {});
  store.prune_frames(2, "a rule", "2026-07-08T00:00:00Z");
  CHECK(store.check_content(2).holds());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute(
      "CREATE TEMP TABLE kept AS SELECT * FROM frames WHERE frame = 1000000001; UPDATE kept SET frame = 2000000001, "
      "branch = 3; INSERT INTO frames SELECT * FROM kept");
  CHECK_THAT(store.check_content(2).difference, Contains("1 frames") && Contains("2026-07-08T00:00:00Z"));
  CHECK(store_error([&] { (void)store.frames(2); }) == "TB-STORE-PRUNED");
}

TEST_CASE("content check: file texts are compared with their own hashes only if these are valid") {
  NewStore store;
  db::RunRecord record = example_run();
  record.bench_sha256 = std::string(63, 'a');  // no SHA-256
  record.sensor_sha256 = std::string(65, 'a');
  const std::int64_t run = store_example(store, record);
  Connection(store.path(), Access::kReadWrite).execute("UPDATE runs SET bench_toml = 'x', sensor_toml = 'y'");
  CHECK_THAT(store.check_content(run).difference, Contains("the run's row, a sequence, a device, or frame 1 "));
}

TEST_CASE("structure check: deleted nights are reported") {
  NewStore store;
  (void)store.add_night({0, "small", "f", "t", "{}", 1, 1, kUtc, kUtc, "p", {}});
  CHECK(store.check_structure().empty());
  Connection(store.path(), Access::kReadWrite).execute("DELETE FROM nights");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Contains("nights: 1 "));
}

namespace {

// Three runs; the second, with five frames, is read.
struct Looked {
  TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  std::int64_t run = 0, branch = 0;
  Looked() {
    store_example(store);
    const Begun begun = begin_example(store);
    run = begun.run;
    branch = begun.branch;
    for (int i = 0; i < 5; ++i) store.append_frame(run, example_frame(branch, i));
    const Begun next = begin_example(store);
    store.append_frame(next.run, example_frame(next.branch, 9));
  }
  [[nodiscard]] db::RunFrameReader look() const { return {RunStore::open_read_only(store.path()), run}; }
};

Positions after(db::RunFrameReader& look, std::int64_t position, int most) {
  Positions seen;
  look.frames_after(position, most, [&](const db::StoredFrame& frame) { seen.push_back(frame.position); });
  return seen;
}

}  // namespace

TEST_CASE("live frames: frames after a position come in order, up to the limit, and only from their run") {
  const Looked looked;
  db::RunFrameReader look = looked.look();
  CHECK(after(look, 0, 99) == Positions{1, 2, 3, 4, 5});
  CHECK(after(look, 0, 2) == Positions{1, 2});
  CHECK(after(look, 2, 2) == Positions{3, 4});
  CHECK(after(look, 4, 2) == Positions{5});
  CHECK(after(look, 5, 2).empty());
  CHECK(after(look, 3, 0).empty());
  CHECK(after(look, -1, 1) == Positions{1});
  CHECK(after(look, -2, 99) == Positions{1, 2, 3, 4, 5});  // none of the run before
}

TEST_CASE("live frames: the position of the last frame before the newest n frames, or 0 if there is no such frame") {
  const Looked looked;
  db::RunFrameReader look = looked.look();
  CHECK(look.before_newest(0) == 5);
  CHECK(look.before_newest(2) == 3);
  CHECK(look.before_newest(4) == 1);
  CHECK(look.before_newest(5) == 0);
  CHECK(look.before_newest(99) == 0);
  const RunStore reader = RunStore::open_read_only(looked.store.path());
  CHECK(db::RunFrameReader(reader, 99).before_newest(0) == 0);
  CHECK_FALSE(db::RunFrameReader(reader, 99).newest());
}

TEST_CASE("live frames: a frame has all its measured data, and whether it is void") {
  Looked looked;
  db::FrameRecord bare = example_frame(looked.branch, 7);
  bare.wrench.reset();
  bare.flags.clear();
  looked.store.append_frame(looked.run, bare);
  db::RunFrameReader look = looked.look();
  std::vector<db::StoredFrame> seen;
  look.frames_after(4, 9, [&](const db::StoredFrame& frame) { seen.push_back(frame); });
  REQUIRE(seen.size() == 2);
  const db::FrameRecord given = example_frame(looked.branch, 4);
  CHECK((seen[0].position == 5 && seen[0].time_ns == given.time_ns && seen[0].setpoint_psi == given.setpoint_psi));
  CHECK((seen[0].feedback_psi == given.feedback_psi && seen[0].reference_psi == given.reference_psi));
  CHECK((seen[0].rows == 3 && seen[0].columns == 2 && seen[0].scans == 2 && seen[0].counts == given.counts));
  CHECK((seen[0].flags == "dwell" && !seen[0].is_void));
  REQUIRE(seen[0].wrench);
  CHECK((seen[0].wrench->target_n == 6.1 && seen[0].wrench->force_start_n == 6.3));
  CHECK((seen[0].wrench->wrench == given.wrench->wrench && seen[0].wrench->place_mm == given.wrench->place_mm));
  CHECK((seen[1].position == 6 && seen[1].flags.empty() && !seen[1].wrench));
  looked.store.void_branch(looked.branch, "scanner lost");
  REQUIRE(look.newest());
  CHECK(look.newest()->is_void);
  Connection(looked.store.path(), Access::kReadWrite)
      .execute("PRAGMA foreign_keys = OFF; UPDATE frames SET branch = 77 WHERE frame = 2000000006");
  CHECK_FALSE(look.newest()->is_void);  // of no branch
}

TEST_CASE("live frames: a pressed frame without force still has its wrench") {
  Looked looked;
  db::FrameRecord frame = example_frame(looked.branch, 7);
  frame.wrench->target_n = 0.0;
  frame.wrench->force_start_n = 0.0;
  looked.store.append_frame(looked.run, frame);
  db::RunFrameReader look = looked.look();
  const std::optional<db::StoredFrame> seen = look.newest();
  REQUIRE((seen && seen->wrench));
  CHECK((seen->wrench->target_n == 0.0 && seen->wrench->force_start_n == 0.0));
  CHECK((seen->wrench->wrench == frame.wrench->wrench && seen->wrench->place_mm == frame.wrench->place_mm));
}

TEST_CASE("live frames: a frame whose counts do not fit its shape is refused, and the next query finds the others") {
  const Looked looked;
  Connection(looked.store.path(), Access::kReadWrite)
      .execute("PRAGMA ignore_check_constraints = ON; UPDATE frames SET scans = 3 WHERE frame = 2000000004");
  db::RunFrameReader look = looked.look();
  CHECK(store_error([&] { (void)after(look, 2, 9); }) == "TB-STORE-SQL");
  CHECK(after(look, 4, 9) == Positions{5});
}

TEST_CASE("live frames: a reader that stops part way does not hold the writer's log") {
  Looked looked;
  db::RunFrameReader look = looked.look();
  CHECK(after(look, 0, 2).size() == 2);
  const auto breaks_off = [](const db::StoredFrame&) { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(look.frames_after(0, 9, breaks_off), "enough");
  REQUIRE(look.newest());
  looked.store.append_frame(looked.run, example_frame(looked.branch, 5));
  Connection writer(looked.store.path(), Access::kReadWrite, 0);
  CHECK(writer.integer("PRAGMA wal_checkpoint(TRUNCATE)") == 0);  // 1: somebody still reads it
  CHECK(std::filesystem::file_size(looked.store.path() + "-wal") == 0);
  CHECK(look.newest()->position == 6);
}

TEST_CASE("live events: events of one run come newest first, no more than requested") {
  NewStore store;
  const Begun begun = begin_example(store);
  for (int i = 1; i <= 4; ++i) store.append_event(begun.run, {i, "kind", "TB-ID", std::to_string(i)});
  store.append_event(begin_example(store).run, {9, "other", "", ""});
  std::vector<std::string> seen;
  store.newest_events(begun.run, [&](const db::EventRecord& event) {
    CHECK((event.kind == "kind" && event.id == "TB-ID" && std::to_string(event.time_ns) == event.detail));
    seen.push_back(event.detail);
    return seen.size() < 3;
  });
  CHECK(seen == std::vector<std::string>{"4", "3", "2"});
}

TEST_CASE("live frames: mean counts of a frame are the means of its scans, per taxel") {
  db::StoredFrame frame;
  frame.scans = 2;
  frame.rows = 1;
  frame.columns = 3;
  frame.counts = {1, 2, 65535, 4, 2, 65534};
  CHECK(db::mean_counts(frame) == std::vector<double>{2.5, 2.0, 65534.5});
  frame.scans = 1;
  frame.rows = 3;
  frame.columns = 2;
  CHECK(db::mean_counts(frame) == std::vector<double>{1, 2, 65535, 4, 2, 65534});
}

// Which runs and checks a question finds, condition by condition.

namespace {

Numbers numbers_of(const std::vector<db::RunRecord>& runs) {
  Numbers numbers;
  for (const db::RunRecord& run : runs) numbers.push_back(run.run);
  return numbers;
}

}  // namespace

TEST_CASE("run lookup: runs are found by sensor, start and content, and by all of these at once") {
  NewStore store;
  db::SensorRecord other = example_sensor();
  other.serial = "S-2";
  store.add_sensor(other);
  for (const auto& [serial, start] :
       {std::pair("S-1", "2026-01-01T00:00:00Z"), std::pair("S-2", "2026-01-02T00:00:00Z"),
        std::pair("S-1", "2026-01-03T00:00:00Z")}) {
    db::RunRecord record = example_run();
    record.sensor_serial = serial;
    record.started_utc = start;
    store_example(store, record);
  }
  const std::string content = store.run(1).content_sha256;  // 1 and 3 have the same: their start does not count
  REQUIRE(store.run(3).content_sha256 == content);
  const auto found = [&](const std::string& serial, const std::string& since, const std::string& sha256) {
    db::RunFilter filter;
    filter.sensor_serial = serial;
    filter.since_utc = since;
    filter.content_sha256 = sha256;
    return numbers_of(store.runs(filter));
  };
  CHECK(numbers_of(store.runs()) == Numbers{1, 2, 3});
  CHECK(found("", "", "") == Numbers{1, 2, 3});
  CHECK(found("S-1", "", "") == Numbers{1, 3});
  CHECK(found("S-2", "", "") == Numbers{2});
  CHECK(found("S-3", "", "").empty());
  CHECK(found("", "2026-01-02T00:00:00Z", "") == Numbers{2, 3});
  CHECK(found("", "2026-01-02T00:00:01Z", "") == Numbers{3});
  CHECK(found("", "", content) == Numbers{1, 3});
  CHECK(found("S-1", "2026-01-02T00:00:00Z", "") == Numbers{3});
  CHECK(found("S-2", "", content).empty());
  CHECK(found("", "2026-01-02T00:00:00Z", content) == Numbers{3});
  CHECK(found("S-1", "2026-01-01T00:00:00Z", content) == Numbers{1, 3});
  CHECK(found("S-1", "2026-01-03T00:00:00Z", content) == Numbers{3});
}

TEST_CASE("run lookup: the last check is that of one sensor, kind and verdict, in an earlier run") {
  NewStore store;
  db::SensorRecord other = example_sensor();
  other.serial = "S-2";
  store.add_sensor(other);
  const std::int64_t first = begin_example(store).run, second = begin_example(store).run;
  db::RunRecord elsewhere = example_run();
  elsewhere.sensor_serial = "S-2";
  const std::int64_t third = begin_example(store, elsewhere).run;
  store.append_check(first, {first, 1, "seating", "pass", R"({"a":1})", {0.5}});
  store.append_check(first, {first, 2, "seating", "pass", R"({"a":2})", {1.5, 2.5}});
  store.append_check(second, {second, 3, "seating", "fail", "{}", {}});
  store.append_check(second, {second, 4, "tare", "pass", "{}", {}});
  store.append_check(third, {third, 5, "seating", "pass", "{}", {}});
  const auto time = [&](const std::string& serial, const std::string& kind, const std::string& verdict,
                        std::int64_t before) {
    const auto check = store.last_check(serial, kind, verdict, before);
    return check ? check->time_ns : 0;
  };
  CHECK(time("S-1", "seating", "pass", 99) == 2);
  CHECK(time("S-1", "seating", "pass", second) == 2);
  CHECK(time("S-1", "seating", "pass", first) == 0);
  CHECK(time("S-1", "seating", "fail", 99) == 3);
  CHECK(time("S-1", "seating", "fail", second) == 0);
  CHECK(time("S-1", "tare", "pass", 99) == 4);
  CHECK(time("S-1", "tare", "fail", 99) == 0);
  CHECK(time("S-2", "seating", "pass", 99) == 5);
  const auto check = store.last_check("S-1", "seating", "pass", 99);
  REQUIRE(check);
  CHECK((check->run == first && check->kind == "seating" && check->verdict == "pass"));
  CHECK((check->detail_json == R"({"a":2})" && check->data == std::vector<double>{1.5, 2.5}));
}

TEST_CASE("run lookup: counts of an empty run are 0, and queries of an unknown run are errors") {
  NewStore store;
  const std::int64_t empty = begin_example(store).run;
  CHECK((store.frame_count(empty) == 0 && store.flagged_frame_count(empty) == 0));
  CHECK(store.scans_of_first_frame(empty) == 0);
  CHECK(store.last_time_ns(empty) == 0);
  CHECK(store_error([&] { (void)store.flagged_frame_count(99); }) == "TB-STORE-NOT-FOUND");
  CHECK(store_error([&] { (void)store.scans_of_first_frame(99); }) == "TB-STORE-NOT-FOUND");
  CHECK(store_error([&] { (void)store.why_not_pruned(99); }) == "TB-STORE-NOT-FOUND");
  CHECK(store_error([&] { (void)store.prune_frames(99, "a rule", kUtc); }) == "TB-STORE-NOT-FOUND");
}

TEST_CASE("run lookup: flagged frames, first frame and last time are those of the run itself") {
  NewStore store;
  const auto with_scans = [&](const Begun& begun, int scans, const std::string& flags) {
    db::FrameRecord frame = example_frame(begun.branch, scans);
    frame.scans = scans;
    frame.counts.resize(static_cast<std::size_t>(6 * scans));
    frame.flags = flags;
    store.append_frame(begun.run, frame);
  };
  const Begun first = begin_example(store), second = begin_example(store), third = begin_example(store);
  for (const auto& [begun, scans] : {std::pair(first, 2), std::pair(second, 3), std::pair(third, 4)}) {
    with_scans(begun, scans, "dwell");
    with_scans(begun, scans + 10, "");
    with_scans(begun, scans + 20, "left-band");
  }
  CHECK(store.flagged_frame_count(second.run) == 2);
  CHECK(store.frame_count(second.run) == 3);
  CHECK(store.scans_of_first_frame(first.run) == 2);
  CHECK(store.scans_of_first_frame(second.run) == 3);
  CHECK(store.last_time_ns(second.run) == example_frame(1, 23).time_ns);
}

TEST_CASE("run lookup: frame times are found by position, and not beyond the run's own frames") {
  NewStore store;
  const std::int64_t first = store_example(store), run = store_example(store);
  CHECK(store.last_position(run) == 3);
  CHECK(store.last_position(first) == 3);
  CHECK(store.last_position(99) == 0);
  CHECK(store.last_position(store.begin_run(example_run())) == 0);
  for (int round = 0; round < 2; ++round) {
    for (std::int64_t position = 1; position <= 3; ++position) {
      const auto found = store.frame_time(run, position);
      REQUIRE(found);
      CHECK((found->sequence == 1 && found->repeat == 0 && found->ordinal == (position == 3 ? 1 : 0)));
      CHECK(found->is_void == (position == 1));
      CHECK(found->time_ns == example_frame(1, found->ordinal).time_ns);
    }
    CHECK_FALSE(store.frame_time(run, 0));
    CHECK_FALSE(store.frame_time(run, 4));
  }
}

TEST_CASE("run lookup: timed events are those that change the state or start a way back") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.set_state(begun.run, "running", {5, "state", "", "prepared -> running"});
  store.append_event(begun.run, {6, "fault", "TB-SCANNER-SILENT", "no report"});
  store.append_event(begun.run, {7, "way-back", "", "branch 1"});
  const auto found = store.timed_events(begun.run);
  REQUIRE(found.size() == 2);
  CHECK((found[0].time_ns == 5 && found[0].kind == "state" && found[0].detail == "prepared -> running"));
  CHECK((found[1].time_ns == 7 && found[1].kind == "way-back" && found[1].detail == "branch 1"));
}

TEST_CASE("run lookup: timed sequences are those of the newest completed runs of a bench, newest first") {
  NewStore store;
  store_example(store);
  const std::int64_t second = store_example(store);
  db::RunRecord elsewhere = example_run();
  elsewhere.bench_id = "bench-b";
  store_example(store, elsewhere);
  const std::int64_t last = store_example(store);
  const std::int64_t stopped = store.begin_run(example_run());
  store.end_run(stopped, db::Outcome::kStopped, "", db::SafeState::kVerified, kUtc);
  const auto found = store.timed_sequences("bench-a", 2);
  REQUIRE(found.size() == 4);
  CHECK((found[0].run == last && found[0].sequence == 0 && found[1].run == last && found[1].sequence == 1));
  CHECK((found[2].run == second && found[3].run == second));
  CHECK((found[1].recipe_sha256 == "rb" && found[1].repeats == 1 && found[1].frames_per_repeat == 4));
  CHECK(found[1].overrides_json == example_run().overrides_json);
  CHECK(store.timed_sequences("bench-b", 9).size() == 2);
  CHECK(store.timed_sequences("bench-c", 9).empty());
}

namespace {

// The finding for a run of `frames` frames after `sql`.
std::string named_after(int frames, bool ended, const std::string& sql) {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const Begun begun = begin_example(store);
  for (int i = 0; i < frames; ++i) store.append_frame(begun.run, example_frame(begun.branch, i));
  store.append_event(begun.run, {1, "note", "", "by hand"});
  if (ended) store.end_run(begun.run, db::Outcome::kStopped, "stopped", db::SafeState::kVerified, kUtc);
  CHECK(store.check_content(begun.run).holds());
  CHECK(store.check_content(begun.run).frames == frames);
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  return store.check_content(begun.run).difference;
}

}  // namespace

TEST_CASE(
    "content check: for a run without frames the run's row is named, and changed file texts by their own hashes") {
  CHECK_THAT(named_after(0, true, "UPDATE runs SET operator = 'X'"), Contains("run's row") && Contains("now 0"));
  CHECK_THAT(named_after(0, true, "UPDATE runs SET bench_toml = 'X'"), Contains("bench file") && !Contains("now 0"));
  CHECK_THAT(named_after(0, true, "UPDATE events SET detail = 'X'"), Contains("an event") && Contains("run's row"));
  CHECK_THAT(named_after(2, true, "UPDATE events SET detail = 'X'"), Contains("now 2") && !Contains("run's row"));
}

TEST_CASE("content check: an open run has no hash of its end, and its frames are checked") {
  CHECK(named_after(3, false, "SELECT 1").empty());
  CHECK_THAT(named_after(3, false, "UPDATE frames SET status = 7 WHERE frame % 10 = 3"),
             Contains("frame 3 ") && Contains("its row"));
  CHECK_THAT(named_after(3, false, "UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 2"),
             Contains("link") && Contains("frame 2 "));
  CHECK_THAT(named_after(3, false, "UPDATE runs SET content_sha256 = 'x'"), Contains("stored hash itself"));
  // An event of an open run may still come.
  CHECK(named_after(3, false, "INSERT INTO events (run, time_ns, kind, id, detail) VALUES (1, 1, '', '', '')").empty());
}

TEST_CASE("content check: of several changes the first is named") {
  CHECK_THAT(named_after(5, true,
                         "UPDATE frames SET status = 7 WHERE frame % 10 = 2; DELETE FROM frames WHERE frame % 10 = 4"),
             Contains("frame 2 ") && !Contains("missing"));
  CHECK_THAT(named_after(5, true,
                         "DELETE FROM frames WHERE frame % 10 = 2; UPDATE frames SET status = 7 WHERE frame % 10 = 4"),
             Contains("frame 2 is missing"));
  CHECK_THAT(named_after(5, true, "DELETE FROM frames WHERE frame % 10 < 3"), Contains("frame 1 is missing"));
  CHECK_THAT(named_after(5, true, "UPDATE frames SET chain = zeroblob(32) WHERE frame % 10 = 1"),
             Contains("link") && Contains("frame 1 "));
  CHECK_THAT(named_after(5, true, "UPDATE frames SET status = 7 WHERE frame % 10 IN (3, 5)"),
             Contains("frame 3 ") && Contains("its row"));
}

TEST_CASE("run store: an unknown text for an outcome or a safe state is refused") {
  NewStore store;
  const std::int64_t run = store_example(store);
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("PRAGMA ignore_check_constraints = ON");
  const auto read_with = [&](const std::string& change) {
    raw.execute("UPDATE runs SET " + change);
    return store_error([&] { (void)store.run(run); });
  };
  CHECK(read_with("outcome = 'done'") == "TB-STORE-SQL");
  CHECK(read_with("outcome = 'completed', safe_state = 'fine'") == "TB-STORE-SQL");
  CHECK(read_with("safe_state = 'verified'").empty());
}

TEST_CASE("run store: the last time of a run is that of its last frame or event, whichever is later") {
  NewStore store;
  const Begun begun = begin_example(store);
  CHECK(store.last_time_ns(begun.run) == 0);
  store.append_event(begun.run, {7, "note", "", ""});
  CHECK(store.last_time_ns(begun.run) == 7);
  store.append_frame(begun.run, example_frame(begun.branch, 3));
  CHECK(store.last_time_ns(begun.run) == example_frame(1, 3).time_ns);
  store.append_event(begun.run, {example_frame(1, 3).time_ns + 1, "note", "", ""});
  CHECK(store.last_time_ns(begun.run) == example_frame(1, 3).time_ns + 1);
  CHECK(store.last_time_ns(99) == 0);
}

TEST_CASE("run lookup: a run is found by its UUID, and an unknown UUID finds no run") {
  NewStore store;
  CHECK(store.run_of_uuid("") == 0);
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK(store.run_of_uuid(store.run(first).uuid) == first);
  CHECK(store.run_of_uuid(store.run(second).uuid) == second);
  CHECK(store.run_of_uuid(store.run(first).uuid + "0") == 0);
}

TEST_CASE("time estimates: void runs are not used") {
  NewStore store;
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK(store.timed_sequences("bench-a", 5).size() == 4);
  store.void_run(second, "gauge closed", "K. Lee", "2026-01-01T00:00:00Z");
  const std::vector<db::TimedSequence> left = store.timed_sequences("bench-a", 5);
  REQUIRE(left.size() == 2);
  CHECK(left.front().run == first);
}

TEST_CASE("run store: frames whose counts do not fit their shape are not returned") {
  NewStore store;
  store_example(store);
  const auto read_with = [&](const std::string& change) {
    Connection(store.path(), Access::kReadWrite)
        .execute("PRAGMA ignore_check_constraints = ON; UPDATE frames SET " + change);
    return store_error([&] { (void)store.frames(1); });
  };
  CHECK(read_with("scans = 9 WHERE frame % 10 = 2") == "TB-STORE-SQL");
  CHECK(read_with("scans = 2").empty());
  CHECK(read_with("columns = 2147483647, \"rows\" = 2147483647") == "TB-STORE-SQL");
  CHECK(read_with("columns = 2, \"rows\" = 0") == "TB-STORE-SQL");
  CHECK_FALSE(store.check_content(1).holds());
}

TEST_CASE("structure check: broken references and violated constraints are reported") {
  NewStore store;
  store_example(store);
  CHECK(store.check_structure().empty());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON");
  raw.execute("UPDATE events SET run = 9 WHERE event = 2");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Catch::Contains("row 2 of events"));
  raw.execute("UPDATE runs SET outcome = 'done'");
  CHECK(store.check_structure().size() == 2);
}
