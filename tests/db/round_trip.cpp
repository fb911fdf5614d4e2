#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "bench/common/error.h"
#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "db/store_file.h"
#include "tests/db/new_store.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

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

TEST_CASE("run store: fits and verdicts read back exactly") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::FitRecord fit{0, run, "elam", true, 256, R"({"p":[-0.0,5e-324]})", "a build", "0.1.0", "2024-05-02T00:00:00Z"};
  const std::int64_t first = store.add_fit(fit), second = store.add_fit(fit);
  fit.model = "gpi";
  fit.stands = false;
  const std::int64_t rival = store.add_fit(fit);
  CHECK(store.default_fit(run)->fit == second);
  CHECK(store.fits(run).back().fit == rival);
  const db::FitRecord got = store.fit(first);
  CHECK((got.fit == first && got.run == run && got.model == "elam" && got.stands && got.fitted == 256));
  CHECK((got.document == fit.document && got.made_by == "a build" && got.program_version == "0.1.0"));
  CHECK(got.created_utc == fit.created_utc);

  db::VerdictRecord verdict{0, 0, "mpe", "span", 0.1 + 0.2, 1.5, "psi", "guarded", "pass", "limits", "sha"};
  verdict.low_psi = 4.0;
  verdict.high_psi = 40.5;
  verdict.direction = "down";
  verdict.share = 0.95;
  verdict.expanded = 0.1;
  store.replace_verdicts(run, first, {verdict, verdict});
  store.replace_verdicts(run, second, {verdict});
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run);
  REQUIRE(verdicts.size() == 1);
  CHECK((verdicts[0].run == run && verdicts[0].fit == second && verdicts[0].criterion == verdict.criterion));
  CHECK((verdicts[0].scope_kind == "span" && verdicts[0].value == 0.1 + 0.2 && verdicts[0].limit == 1.5));
  CHECK((verdicts[0].low_psi == 4.0 && verdicts[0].high_psi == 40.5 && verdicts[0].direction == "down"));
  CHECK((verdicts[0].share == 0.95 && verdicts[0].expanded == 0.1));
  CHECK((verdicts[0].unit == "psi" && verdicts[0].rule == "guarded" && verdicts[0].limits_sha256 == "sha"));
  CHECK(store_error([&] { store.replace_verdicts(run, 99, {}); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.verdicts(run).size() == 1);
  CHECK(verdicts[0].model_run == run);
  store.replace_verdicts(run, rival, {verdict});
  REQUIRE(store.verdicts(run).size() == 2);
  CHECK((store.verdicts(run)[0].fit == second && store.verdicts(run)[1].fit == rival));
}

TEST_CASE("run store: verdicts by other limits or by models of another run are not replaced") {
  NewStore store;
  const std::int64_t judged = store_example(store), one = store_example(store), other = store_example(store);
  const auto fit_of_run = [&](std::int64_t run) {
    return store.add_fit({0, run, "elam", true, 1, "{}", "", "0.1.0", "2024-05-02T00:00:00Z"});
  };
  const auto by_limits = [](const char* sha256, const char* word) {
    db::VerdictRecord verdict{0, 0, "mean_compensation_error", "array", 1.0, 1.5, "psi", "simple", word, "l", sha256};
    return std::vector<db::VerdictRecord>{verdict};
  };
  store.replace_verdicts(judged, fit_of_run(one), by_limits("strict", "fail"));
  store.replace_verdicts(judged, fit_of_run(one), by_limits("wide", "pass"));
  store.replace_verdicts(judged, fit_of_run(other), by_limits("strict", "pass"));
  store.replace_verdicts(judged, fit_of_run(one), {});  // report only
  const auto words = [](const std::vector<db::VerdictRecord>& verdicts) {
    std::string text;
    for (const db::VerdictRecord& verdict : verdicts) text += verdict.limits_sha256 + " " + verdict.verdict + "; ";
    return text;
  };
  CHECK(words(store.verdicts(judged)) == "strict fail; wide pass; strict pass; ");
  CHECK(words(store.verdicts_of_models(one)) == "strict fail; wide pass; ");
  CHECK(words(store.verdicts_of_models(other)) == "strict pass; ");
  CHECK(store.verdicts_of_models(judged).empty());
  store.replace_verdicts(judged, fit_of_run(one), by_limits("strict", "inconclusive"));
  CHECK(words(store.verdicts_of_models(one)) == "wide pass; strict inconclusive; ");
  CHECK(store.verdicts_of_models(one).back().model_run == one);
}

TEST_CASE("run store: rows that contradict the run are refused and leave nothing") {
  NewStore store;
  const std::int64_t ended = store_example(store);
  const Begun begun = begin_example(store);
  const std::string before = store.content_hash(begun.run);
  db::FrameRecord frame = example_frame(begun.branch, 0);
  frame.counts.pop_back();
  CHECK(store_error([&] { store.append_frame(begun.run, frame); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.append_frame(begun.run, example_frame(1, 0)); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.void_branch(1, "late"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.set_state(begun.run, "ended", {}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.end_run(begun.run, db::Outcome::kIncomplete, "", {}, ""); }) == "TB-STORE-CONFLICT");
  // That it has ended is reported first, whatever else is wrong.
  RunStore reader = RunStore::open_read_only(store.path());
  CHECK(store_error([&] { reader.end_run(ended, db::Outcome::kFailed, "", {}, ""); }) == "TB-STORE-CONFLICT");
  CHECK(store.content_hash(begun.run) == before);
  store.set_devices(begun.run, {});
  CHECK(store.run(begun.run).devices.empty());
  frame = example_frame(begun.branch, 0);
  frame.setpoint_psi = kNaN;  // the database itself refuses: the chain must not have advanced
  CHECK(store_error([&] { store.append_frame(begun.run, frame); }) == "TB-STORE-CONFLICT");
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.set_devices(begun.run, {}); }) == "TB-STORE-CONFLICT");
  store.end_run(begun.run, db::Outcome::kFailed, "r", db::SafeState::kFailed, "");
  CHECK(store.run(begun.run).content_sha256 == store.content_hash(begun.run));
}

TEST_CASE("UUID: new UUIDs are of version 4 and differ") {
  const std::string form = "xxxxxxxx-xxxx-4xxx-yxxx-xxxxxxxxxxxx";
  for (int round = 0; round < 64; ++round) {
    const std::string uuid = db::new_uuid();
    REQUIRE(uuid.size() == form.size());
    for (std::size_t i = 0; i < form.size(); ++i) {
      const std::string allowed = form[i] == 'x'   ? "0123456789abcdef"
                                  : form[i] == 'y' ? "89ab"
                                                   : std::string(1, form[i]);
      CHECK(allowed.find(uuid[i]) != std::string::npos);
    }
    CHECK(uuid != db::new_uuid());
  }
}

// Rows of a run at the edges that neighbours and changes from outside make: branches in turn, keys of tags, frames of
// no branch, frames that came back.

using Catch::Contains;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("run store: interleaved frames of two branches and two runs each keep their own branch") {
  NewStore store;
  const Begun one = begin_example(store), other = begin_example(store);
  db::BranchRecord next = example_branch();
  next.ordinal = 1;
  const std::int64_t second = store.begin_branch(one.run, next);
  for (int i = 0; i < 3; ++i) {
    store.append_frame(one.run, example_frame(one.branch, i));
    store.append_frame(one.run, example_frame(second, i));
    store.append_frame(other.run, example_frame(other.branch, i));
  }
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  store.append_frame(other.run, example_frame(other.branch, 3));
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  for (const std::int64_t run : {one.run, other.run}) {
    store.end_run(run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    CHECK(store.check_content(run).holds());
    CHECK(store.content_hash(run) == store.run(run).content_sha256);
  }
  CHECK((store.frame_count(one.run) == 6 && store.frame_count(other.run) == 4));
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

TEST_CASE("run copy: runs copied in any order keep their verdicts and the fits of these") {
  NewStore source, target;
  for (int i = 0; i < 3; ++i) store_example(source);
  const auto fit_of = [&](std::int64_t run, const std::string& model) {
    return source.add_fit({0, run, model, true, 1, std::to_string(run), "", "0.1.0", kUtc});
  };
  const std::int64_t of_two = fit_of(2, "two"), of_three = fit_of(3, "three"), again = fit_of(3, "again");
  const auto verdict = [](const std::string& criterion) {
    db::VerdictRecord record;
    record.criterion = criterion;
    record.verdict = "pass";
    record.limits_sha256 = criterion;
    return record;
  };
  source.replace_verdicts(1, of_two, {verdict("by two")});
  source.replace_verdicts(1, of_three, {verdict("by three")});
  source.replace_verdicts(1, again, {verdict("by again")});
  store_example(target);
  (void)target.add_fit({0, 1, "own", true, 1, "{}", "", "0.1.0", kUtc});
  CHECK(target.copy_runs_from(source, {3, 1}) == std::vector<std::int64_t>{2, 3});
  CHECK(target.copy_runs_from(source, {2}) == std::vector<std::int64_t>{4});
  const std::vector<db::VerdictRecord> verdicts = target.verdicts(3);
  REQUIRE(verdicts.size() == 3);
  CHECK((verdicts[0].criterion == "by two" && verdicts[0].fit == 0));  // the run of its fit came later
  CHECK((verdicts[1].criterion == "by three" && target.fit(verdicts[1].fit).model == "three"));
  CHECK((verdicts[2].criterion == "by again" && target.fit(verdicts[2].fit).model == "again"));
  CHECK(verdicts[1].model_run == 2);
  REQUIRE(target.fits(4).size() == 1);
  CHECK(target.fits(4)[0].document == "2");
  for (const std::int64_t run : {2, 3, 4}) {
    CHECK(target.check_content(run).holds());
    CHECK(target.check_seals(run).empty());
  }
  CHECK(target.check_structure().empty());
  CHECK(store_error([&] { (void)target.copy_runs_from(source, {1}); }) == "TB-STORE-EXISTS");
}

TEST_CASE("structure check: deleted nights are reported") {
  NewStore store;
  (void)store.add_night({0, "small", "f", "t", "{}", 1, 1, kUtc, kUtc, "p", {}});
  CHECK(store.check_structure().empty());
  Connection(store.path(), Access::kReadWrite).execute("DELETE FROM nights");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Contains("nights: 1 "));
}

// Each bit of the header of a store's file, flipped: reading or writing reports it, or is not affected.

namespace {

constexpr std::size_t kHeaderBytes = 100;

// True when `use` ends with an error, which must be one of the store.
template <class Use>
bool told(Use use) {
  try {
    use();
    return false;
  } catch (const db::StoreError&) {
    CHECK(bench::as_error(std::current_exception()).code() == bench::ExitCode::kStore);
    return true;
  }
}

bool as_it_was(const RunStore& store, const std::string& content) {
  return store.content_hash(1) == content && store.check_content(1).holds() && store.check_seals(1).empty();
}

void write_something(RunStore& store) {
  store.add_note(1, "written after the flip");
  db::RunRecord record = example_run();
  record.purpose = std::string(30'000 / 4, 'x');  // more than a page
  const std::int64_t run = store.begin_run(record);
  const std::int64_t branch = store.begin_branch(run, example_branch());
  for (int i = 0; i < 5; ++i) store.append_frame(run, example_frame(branch, i));
  store.end_run(run, db::Outcome::kStopped, "", db::SafeState::kVerified, "2024-05-02T10:00:00Z");
}

void remove_all_of(const std::string& path) {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path + ending);
}

struct Fates {
  int refused = 0, harmless = 0;
};

Fates flip_each(const std::string& whole, const std::string& content, std::size_t first, std::size_t end) {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  Fates fates;
  for (std::size_t bit = 8 * first; bit < 8 * end; ++bit) {
    CAPTURE(bit / 8, bit % 8);
    std::string bytes = whole;
    bytes[bit / 8] = static_cast<char>(static_cast<unsigned char>(bytes[bit / 8]) ^ (1U << (bit % 8)));
    write_file(path, bytes);
    bool same = true;
    const bool read = !told([&] { same = as_it_was(RunStore::open_read_only(path), content); });
    CHECK(same);
    remove_all_of(path);
    write_file(path, bytes);
    const bool written = !told([&] {
      RunStore store = RunStore::open(path, db::Durability::kNormal);
      write_something(store);
    });
    CHECK(!(written && !read));
    if (read) {  // rows of a refused attempt are not lost either
      CHECK_FALSE(told([&] { same = as_it_was(RunStore::open_read_only(path), content); }));
      CHECK(same);
    }
    ++(written ? fates.harmless : fates.refused);
    remove_all_of(path);
  }
  return fates;
}

std::string store_in(const std::string& path, bool with_free_pages) {
  std::string content;
  {
    RunStore store = RunStore::open(path, db::Durability::kNormal);
    content = store.run(store_example(store)).content_sha256;
  }
  if (with_free_pages)
    Connection(path, Access::kReadWrite)
        .execute("CREATE TABLE gone (b BLOB); INSERT INTO gone VALUES (zeroblob(20000)); DROP TABLE gone");
  REQUIRE_FALSE(std::filesystem::exists(path + "-wal"));
  return content;
}

}  // namespace

TEST_CASE("store header: each flipped bit is refused, or does not affect reading and writing") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), false);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 0, kHeaderBytes);
  CHECK(fates.refused + fates.harmless == 800);
  CHECK(fates.refused > 400);   // page size, versions, formats, pages, encoding, schema, application
  CHECK(fates.harmless > 100);  // counters of changes, reserved bytes, the version of the library
}

TEST_CASE("store header: each flipped bit of the page fields is refused or harmless, also with free pages") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), true);
  REQUIRE(Connection(folder.path("runs.db"), Access::kReadOnly).integer("PRAGMA freelist_count") > 3);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 24, 40);
  CHECK(fates.refused + fates.harmless == 128);
}

TEST_CASE("store header: an impossible schema version is reported as damage") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  for (const int version : {-1, -5, -2147483647, 0}) {
    Connection(path, Access::kReadWrite).execute("PRAGMA user_version = " + std::to_string(version));
    CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { (void)db::schema_version_of(path); }) == "TB-STORE-OPEN");
  }
  CHECK_FALSE(std::filesystem::exists(path + ".schema--1.backup"));
}
