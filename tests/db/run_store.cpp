// Copies of a store that another process is writing, copies of runs, removed frames, and nights.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

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

TEST_CASE("nights: each field of each night reads back, with the results of its own night") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::NightRecord first{
      0, "small", "small.toml", "schema = 1\n", R"({"seeds":2})", 2, 3, "begun one", "end one", "program one", {}};
  first.results = {{7, "g", R"({"x":1})", run}, {1, "a", "{}", 0}};
  db::NightRecord second{0, "large",     "large.toml", "schema = 2\n", "{}", 1,
                         1, "begun two", "end two",    "program two",  {}};
  second.results = {{0, "z", R"({"y":2})", 0}};
  CHECK(store.nights().empty());
  CHECK(store.add_night(first) == 1);
  CHECK(store.add_night(second) == 2);
  const std::vector<db::NightRecord> nights = store.nights();
  REQUIRE(nights.size() == 2);
  CHECK((nights[0].night == 1 && nights[0].suite == "small" && nights[0].suite_file == "small.toml"));
  CHECK((nights[0].suite_toml == "schema = 1\n" && nights[0].selection_json == R"({"seeds":2})"));
  CHECK((nights[0].shard == 2 && nights[0].shards == 3 && nights[0].program == "program one"));
  CHECK((nights[0].begun_utc == "begun one" && nights[0].ended_utc == "end one"));
  REQUIRE(nights[0].results.size() == 2);  // in the order of their positions
  CHECK((nights[0].results[0].position == 1 && nights[0].results[0].label == "a"));
  CHECK((nights[0].results[0].first_run == 0 && nights[0].results[0].json == "{}"));
  CHECK((nights[0].results[1].position == 7 && nights[0].results[1].label == "g"));
  CHECK((nights[0].results[1].first_run == run && nights[0].results[1].json == R"({"x":1})"));
  CHECK((nights[1].night == 2 && nights[1].suite == "large" && nights[1].suite_file == "large.toml"));
  CHECK((nights[1].shard == 1 && nights[1].shards == 1 && nights[1].ended_utc == "end two"));
  REQUIRE(nights[1].results.size() == 1);
  CHECK((nights[1].results[0].label == "z" && nights[1].results[0].json == R"({"y":2})"));
}

TEST_CASE("nights: a night that is refused half way leaves nothing") {
  NewStore store;
  db::NightRecord night{0, "small", "f", "t", "{}", 1, 1, kUtc, kUtc, "p", {}};
  night.results = {{0, "a", "{}", 0}, {0, "a again", "{}", 0}};
  CHECK(store_error([&] { store.add_night(night); }) == "TB-STORE-CONFLICT");
  CHECK(store.nights().empty());
  night.results = {{0, "a", "{}", 99}};  // of a run that nobody has
  CHECK(store_error([&] { store.add_night(night); }) == "TB-STORE-CONFLICT");
  night.results = {{0, "a", "{}", 0}};
  CHECK(store.add_night(night) == 1);
}

TEST_CASE("run copy: approved reports and statistics are copied with their run") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.add_report({run, "1-0a1b2c3d", "0a1b2c3d", "K. Lee", "2026-01-01T00:00:00Z", "", ""});
  store.add_report({run,
                    "1-ffffffff",
                    "ff",
                    "M. Ito",
                    "2026-01-02T00:00:00Z",
                    "1-0a1b2c3d",
                    "serial corrected",
                    {{run, "c1"}, {9, "c2"}}});
  store.replace_figures(run, "sensor", {{"x_psi", 1.0}});
  NewStore other;
  store_example(other);
  const std::int64_t copied = other.copy_runs_from(store, {run}).front();
  const std::vector<db::ReportRecord> reports = other.reports(copied);
  REQUIRE(reports.size() == 2);
  CHECK((reports[0].number == "1-0a1b2c3d" && reports[1].replaces == "1-0a1b2c3d" && reports[1].run == copied));
  CHECK((reports[0].reason.empty() && reports[1].reason == "serial corrected"));
  REQUIRE(reports[1].evidence.size() == 2);
  CHECK((reports[1].evidence[1].run == 9 && reports[1].evidence[1].content_sha256 == "c2"));
  REQUIRE(other.figures("sensor").size() == 1);
  CHECK(other.figures("sensor")[0].run == copied);
}

TEST_CASE("library versions: SQLite and OpenSSL are named with their versions") {
  const auto versions = db::library_versions();
  REQUIRE(versions.size() == 2);
  CHECK((versions[0].first == "SQLite" && versions[0].second.starts_with("3.")));
  CHECK((versions[1].first == "OpenSSL" && versions[1].second.find('.') != std::string::npos));
}

TEST_CASE("snapshot: of a live run has all acknowledged frames, and disturbs neither store nor run") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const std::int64_t done = store_example(store);
  const Begun begun = begin_example(store);
  const RunStore reader = RunStore::open_read_only(folder.path("runs.db"));
  for (int i = 0; i < 20; ++i) {
    store.append_frame(begun.run, example_frame(begun.branch, i));
    const std::string name = folder.path("snapshot-" + std::to_string(i) + ".db");
    (i % 2 == 0 ? store : reader).snapshot(name);
    const RunStore copy = RunStore::open_read_only(name);
    CHECK(copy.frame_count(begun.run) == i + 1);
    CHECK(copy.check_content(begun.run).holds());
    CHECK(copy.check_content(done).holds());
    CHECK(copy.run(done).content_sha256 == store.run(done).content_sha256);
    CHECK(copy.check_structure().empty());
    CHECK_FALSE(std::filesystem::exists(name + ".partial"));
  }
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  CHECK(store.check_content(begun.run).holds());
  RunStore copy = RunStore::open(folder.path("snapshot-3.db"));  // a copy is a store like any other
  CHECK(copy.mark_interrupted("2026-01-01T00:00:00Z") == 1);
}

TEST_CASE("snapshot: overwrites no existing file, and replaces the partial files of a dead program") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  write_file(folder.path("there.db"), "mine");
  CHECK(store_error([&] { store.snapshot(folder.path("there.db")); }) == "TB-STORE-EXISTS");
  CHECK(read_file(folder.path("there.db")) == "mine");
  CHECK(store_error([&] { store.snapshot(folder.path("runs.db")); }) == "TB-STORE-EXISTS");
  CHECK(store_error([&] { store.snapshot(folder.path("none/copy.db")); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { store.snapshot(""); }) == "TB-STORE-OPEN");
  for (const char* ending : {"", "-journal", "-wal", "-shm"})  // of a program that died
    write_file(folder.path("copy.db.partial") + ending, std::string(9000, 'x'));
  store.snapshot(folder.path("copy.db"));
  for (const char* ending : {"", "-journal", "-wal", "-shm"})
    CHECK_FALSE(std::filesystem::exists(folder.path("copy.db.partial") + ending));
  CHECK(RunStore::open_read_only(folder.path("copy.db")).check_content(1).holds());
}

TEST_CASE("snapshot: a program that dies during it leaves no file of that name, and the next one succeeds") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  const std::string copy = folder.path("copy.db");
  CHECK(in_child([&] {
          std::signal(SIGXFSZ, SIG_DFL);
          const rlimit limit{20'000, 20'000};
          if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
          RunStore::open_read_only(folder.path("runs.db")).snapshot(copy);
          return 1;
        }) == -1);
  CHECK_FALSE(std::filesystem::exists(copy));
  const int other = open((copy + ".partial").c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE((other >= 0 && flock(other, LOCK_EX) == 0));  // of one that is at work
  CHECK(store_error([&] { store.snapshot(copy); }) == "TB-STORE-EXISTS");
  close(other);
  store.snapshot(copy);
  CHECK(RunStore::open_read_only(copy).check_content(1).holds());
  CHECK_FALSE(std::filesystem::exists(copy + ".partial"));
}

TEST_CASE("removed store file: new work is refused, later notes are kept, and rescue saves all of it") {
  const auto replaced = GENERATE(false, true);
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path);
  store_example(store);
  store.snapshot(folder.path("older.db"));
  store.add_note(1, "in the log");
  CHECK_NOTHROW(store.require_in_place());
  if (replaced)
    std::filesystem::rename(folder.path("older.db"), path);
  else
    std::filesystem::remove(path);
  CHECK(store_error([&] { store.add_note(1, "not stored"); }) == "TB-STORE-GONE");
  store.add_note(1, "the last word");
  CHECK(store_error([&] { store.require_in_place(); }) == "TB-STORE-GONE");
  write_file(path + ".rescued", "mine");
  const RunStore saved = RunStore::open_read_only(store.rescue());
  CHECK(read_file(path + ".rescued") == "mine");
  CHECK(saved.run(1).notes == "in the log\nthe last word");
  CHECK(saved.check_content(1).holds());
  CHECK_FALSE(std::filesystem::exists(path + "-wal"));
  if (replaced) CHECK(RunStore::open_read_only(path).run(1).notes.empty());
}

TEST_CASE("truncated store file: is detected, and a store that VACUUM shrank is not mistaken for one") {
  const auto bytes = GENERATE(0U, 100U, 3U * 4096U);
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path);
  store_example(store);
  const auto size_after = [&](const std::string& sql) {
    Connection(path, Access::kReadWrite).execute(sql + "; PRAGMA wal_checkpoint(TRUNCATE)");
    CHECK_NOTHROW(store.require_in_place());
    return std::filesystem::file_size(path);
  };
  const auto before = size_after("CREATE TABLE many AS SELECT zeroblob(1000000) AS bytes");
  REQUIRE(size_after("DROP TABLE many; VACUUM") < before);
  CHECK_NOTHROW(store.add_note(1, "smaller"));
  std::filesystem::resize_file(path, bytes);
  CHECK(store_error([&] { store.add_note(1, "not stored"); }) == "TB-STORE-GONE");
  CHECK(store_error([&] { (void)store.rescue(); }) == "TB-STORE-GONE");
  for (const char* ending : {"", "-wal", "-shm"}) CHECK_FALSE(std::filesystem::exists(path + ".rescued" + ending));
}

TEST_CASE("snapshot: without free space ends with TB-STORE-FULL and leaves nothing") {
  const TemporaryFolder folder;
  {
    RunStore store = RunStore::open(folder.path("runs.db"));
    store_example(store);
  }
  CHECK(in_child([&] {
          std::signal(SIGXFSZ, SIG_IGN);
          const RunStore store = RunStore::open_read_only(folder.path("runs.db"));
          const rlimit limit{50'000, 50'000};
          if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
          return store_error([&] { store.snapshot(folder.path("no.db")); }) == "TB-STORE-FULL" ? 0 : 1;
        }) == 0);
  for (const char* ending : {"", ".partial", ".partial-journal", ".partial-wal"}) {
    CHECK_FALSE(std::filesystem::exists(folder.path("no.db") + ending));
  }
}

namespace {

std::size_t open_descriptors() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) count += entry.path().empty() ? 0 : 1;
  return count;
}

}  // namespace

TEST_CASE("snapshot: leaves no descriptor open, and works with descriptor 0") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  store.snapshot(folder.path("first.db"));
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 5; ++i) store.snapshot(folder.path("copy-" + std::to_string(i) + ".db"));
  store_error([&] { store.snapshot(folder.path("first.db")); });
  CHECK(open_descriptors() == before);
  CHECK(in_child([&] {  // without a standard input the name's file gets its number
          close(0);
          const std::string id = store_error([&] { store.snapshot(folder.path("zero.db")); });
          return id.empty() && std::filesystem::exists(folder.path("zero.db")) ? 0 : 1;
        }) == 0);
}

TEST_CASE("run copy: each copied run has its verdicts under seal") {
  NewStore source, target;
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  for (int i = 0; i < 3; ++i) source.replace_verdicts(store_example(source), 0, {verdict});
  store_example(target);
  for (const std::int64_t run : target.copy_runs_from(source, {1, 2, 3})) {
    CAPTURE(run);
    CHECK(target.verdicts(run).size() == 1);
    CHECK(target.check_seals(run).empty());
  }
  CHECK(target.runs().size() == 4);
  CHECK(target.copy_runs_from(source, {}).empty());
}

namespace {

// Run `judged` is judged by a fit of run `fitted`.
void judge(RunStore& store, std::int64_t fitted, std::int64_t judged) {
  db::FitRecord fit;
  fit.run = fitted;
  fit.model = "elam";
  fit.document = R"({"taxels":[]})";
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  verdict.limits_sha256 = "l";
  store.replace_verdicts(judged, store.add_fit(fit), {verdict});
}

void store_judged(RunStore& store) {
  const std::int64_t first = store_example(store), second = store_example(store);
  judge(store, first, second);
  store.set_tags(second, {"night"}, {});
}

}  // namespace

TEST_CASE("run copy: content, tags, fits and verdicts are kept, under the numbers of the other store") {
  NewStore source;
  NewStore target;
  store_judged(source);
  store_judged(target);
  store_example(target);
  CHECK(target.copy_runs_from(source, {1, 2}) == std::vector<std::int64_t>{4, 5});
  for (const std::int64_t run : {1, 2, 3, 4, 5}) CHECK(target.check_content(run).holds());
  CHECK(target.run(4).content_sha256 == source.run(1).content_sha256);
  CHECK(target.run(4).uuid == source.run(1).uuid);
  CHECK(target.run(5).tags == std::vector<std::string>{"night"});
  REQUIRE(target.fits(4).size() == 1);
  CHECK(target.fits(4).front().fit == 2);
  CHECK(target.fit(2).document == source.fit(1).document);
  REQUIRE(target.verdicts(5).size() == 1);
  CHECK(target.verdicts(5).front().fit == 2);
  CHECK(target.check_structure().empty());
  CHECK(target.frames(5).size() == 3);
  // The copy works as a store: the next run's keys follow.
  CHECK(store_example(target) == 6);
  CHECK(target.check_content(6).holds());
}

TEST_CASE("run copy: a run is copied once, ended and complete, or nothing is copied") {
  NewStore source;
  NewStore target;
  store_judged(source);
  CHECK(target.copy_runs_from(source, {2}) == std::vector<std::int64_t>{1});
  CHECK(target.verdicts(1).front().fit == 0);  // the run of its models was not copied
  CHECK(store_error([&] { target.copy_runs_from(source, {1, 2}); }) == "TB-STORE-EXISTS");
  CHECK(target.runs().size() == 1);
  const std::int64_t open = source.begin_run(example_run());
  CHECK(store_error([&] { target.copy_runs_from(source, {1, open}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { target.copy_runs_from(source, {99}); }) == "TB-STORE-NOT-FOUND");
  db::sqlite::Connection(source.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  std::string message;
  CHECK(store_error([&] { target.copy_runs_from(source, {1}); }, &message) == "TB-STORE-CONFLICT");
  CHECK_THAT(message, Catch::Contains("frame 2"));
  CHECK(target.runs().size() == 1);
  CHECK(target.check_structure().empty());
  NewStore third;
  db::SensorRecord other = example_sensor();
  other.type_sha256 = db::sha256_hex("another");
  third.add_sensor(other);
  CHECK(store_error([&] { third.copy_runs_from(source, {2}); }) == "TB-STORE-CONFLICT");
}

namespace {

constexpr const char* kRule = "nights before 2026-01-01";

std::int64_t night_run(RunStore& store, const db::RunRecord& run = example_run()) {
  const std::int64_t number = store_example(store, run);
  store.set_tags(number, {"nightly"}, {});
  return number;
}

}  // namespace

TEST_CASE("prune: removes the frames of a nightly run, and everything else stays and still verifies") {
  NewStore store;
  const std::int64_t run = night_run(store), other = night_run(store);
  store.replace_figures(run, "nightly/a", {{"mean_error_psi", 0.25}});
  const std::string content = store.run(run).content_sha256, frames = db::frames_hash(store, run);
  CHECK(store.why_not_pruned(run).empty());
  const db::PrunedRecord pruned = store.prune_frames(run, kRule, kUtc);
  CHECK((pruned.frames == 3 && pruned.bytes == 3 * (24 + 32)));
  CHECK(store.frame_count(run) == 0);
  CHECK(store.frame_count(other) == 3);
  CHECK(store.run(run).content_sha256 == content);
  CHECK(db::frames_hash(store, run) == frames);
  CHECK(store.events(run).size() == 2);
  CHECK(store.figures("nightly/a").size() == 1);
  CHECK(store.check_structure().empty());
  const db::ContentCheck check = store.check_content(run);
  REQUIRE(check.pruned);
  CHECK((check.holds() && check.frames == 3 && check.computed_sha256 == content && check.pruned->rule == kRule));
  CHECK_FALSE(store.check_content(other).pruned);
  CHECK(store_error([&] { (void)store.frames(run); }) == "TB-STORE-PRUNED");
  CHECK(store_error([&] { store.for_each_frame(run, [](const auto&) {}); }) == "TB-STORE-PRUNED");
  CHECK(store_error([&] { store.prune_frames(run, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  Connection raw(store.path(), Access::kReadOnly);
  CHECK(raw.integer("SELECT frames_pruned FROM v_runs WHERE run = 1") == 3);
}

TEST_CASE("prune: a later change to the rest of a pruned run is detected") {
  const auto difference_after = [](const char* sql) {
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    night_run(store);
    store.prune_frames(1, kRule, kUtc);
    Connection(folder.path("runs.db"), Access::kReadWrite).execute(sql);
    return store.check_content(1).difference;
  };
  CHECK(difference_after("SELECT 1").empty());
  CHECK_THAT(difference_after("UPDATE runs SET seed = 8"), Catch::Contains("the run's row"));
  CHECK_THAT(difference_after("UPDATE runs SET bench_toml = 'x'"), Catch::Contains("the bench file"));
  CHECK_THAT(difference_after("UPDATE devices SET serial = 'x'"), Catch::Contains("a device"));
  CHECK_THAT(difference_after("UPDATE events SET detail = 'x'"), Catch::Contains("an event"));
  CHECK_THAT(difference_after("UPDATE runs SET outcome = 'failed'"), Catch::Contains("the outcome"));
  CHECK_THAT(difference_after("UPDATE pruned SET frames = 4"), Catch::Contains("number of frames"));
  CHECK_THAT(difference_after("UPDATE pruned SET chain = randomblob(32)"), Catch::Contains("the link"));
  CHECK_FALSE(difference_after("DELETE FROM pruned").empty());
}

TEST_CASE("prune: keeps the frames of hardware, non-nightly, void, pinned, reported and open runs") {
  NewStore store;
  db::RunRecord hardware = example_run();
  hardware.origin = "hardware";
  const std::int64_t real = night_run(store, hardware), own = store_example(store), voided = night_run(store),
                     pinned = night_run(store), reported = night_run(store), free = night_run(store);
  store.void_run(voided, "by hand", "K. Lee", kUtc);
  store.set_tags(pinned, {"pinned"}, {});
  store.add_report({reported, "5-0123abcd", "hash", "K. Lee", kUtc, "", ""});
  const std::int64_t open = begin_example(store).run;
  store.set_tags(open, {"nightly"}, {});
  CHECK_THAT(store.why_not_pruned(reported), Catch::Contains("5-0123abcd"));
  CHECK(store.why_not_pruned(free).empty());
  for (const std::int64_t run : {real, own, voided, pinned, reported, open}) {
    CHECK_FALSE(store.why_not_pruned(run).empty());
    CHECK(store_error([&] { store.prune_frames(run, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  }
  CHECK(store.frame_count(real) == 3);
  // Runs on which a verdict of a kept run is based are kept, on either side of the verdict.
  const std::int64_t models = night_run(store), judged = night_run(store);
  judge(store, models, pinned);
  judge(store, reported, judged);
  CHECK_THAT(store.why_not_pruned(models), Catch::Contains("run 4 "));
  CHECK_THAT(store.why_not_pruned(judged), Catch::Contains("run 5 "));
  judge(store, free, night_run(store));
  CHECK(store.why_not_pruned(free).empty());
}

TEST_CASE("prune: a damaged run is not pruned, and a pruned run is not continued") {
  NewStore store;
  night_run(store);
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.end_run(begun.run, db::Outcome::kStopped, "by hand", db::SafeState::kVerified, kUtc);
  store.set_tags(begun.run, {"nightly"}, {});
  store.prune_frames(begun.run, kRule, kUtc);
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");
  Connection(store.path(), Access::kReadWrite).execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  CHECK(store_error([&] { store.prune_frames(1, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  CHECK(store.frame_count(1) == 3);
}

TEST_CASE("prune: a pruned run is copied as pruned, and shrink frees the space of removed frames") {
  NewStore store;
  for (int i = 0; i < 30; ++i) {
    const Begun begun = begin_example(store);
    db::FrameRecord frame = example_frame(begun.branch, 0);
    frame.trace.resize(2000);
    for (int k = 0; k < 5; ++k) store.append_frame(begun.run, frame);
    store.end_run(begun.run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    store.set_tags(begun.run, {"nightly"}, {});
    store.prune_frames(begun.run, kRule, kUtc);
  }
  const auto bytes = [&] { return read_file(store.path()).size(); };
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA wal_checkpoint(TRUNCATE)");
  const std::size_t before = bytes();
  store.shrink();
  CHECK(bytes() + 100'000 < before);  // frames of one run at a time lay there
  CHECK(store.check_structure().empty());
  // Of a program that dies before the shorter file is cut: log and file tell of different lengths.
  const TemporaryFolder folder;
  const std::string dying = folder.path("runs.db");
  db::FrameRecord long_one = example_frame(begin_example(store).branch, 0);
  long_one.trace.resize(2000);
  store.append_frame(31, long_one);
  store.snapshot(dying);
  REQUIRE(in_child([&] {
            auto* raw = new Connection(dying, Access::kReadWrite);  // never closed: the log stays
            raw->execute("PRAGMA wal_autocheckpoint = 0; DELETE FROM frames; VACUUM");
            return 0;
          }) == 0);
  CHECK(RunStore::open_read_only(dying).runs().size() == 31);
  CHECK(RunStore::open(dying).check_structure().empty());
  NewStore copy;
  CHECK(copy.copy_runs_from(store, {3}) == std::vector<std::int64_t>{1});
  REQUIRE(copy.check_content(1).pruned);
  CHECK(copy.check_content(1).holds());
  CHECK(copy.run(1).content_sha256 == store.run(3).content_sha256);
  RunStore::open(store.path());  // the header of a shrunk file is one of a store
}
