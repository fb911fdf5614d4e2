// Copies of a store that another process is writing, and checks of the file.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

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

TEST_CASE("store opening: a store with a log in a read-only folder is not read without the log") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  REQUIRE(in_child([&] {
            auto* store = new RunStore(RunStore::open(path));  // never closed: the log stays
            store_example(*store);
            return 0;
          }) == 0);
  REQUIRE(std::filesystem::file_size(path + "-wal") > 0);
  std::filesystem::remove(path + "-shm");
  chmod(path.c_str(), 0444);
  chmod(folder.path().c_str(), 0555);
  const int code = in_child([&] {
    if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) return 3;
    return store_error([&] { RunStore::open_read_only(path); }).empty() ? 1 : 0;
  });
  chmod(folder.path().c_str(), 0755);
  CHECK(code == 0);
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

// Run 2 is judged by the fit of run 1.
void store_judged(RunStore& store) {
  const std::int64_t first = store_example(store), second = store_example(store);
  db::FitRecord fit;
  fit.run = first;
  fit.model = "elam";
  fit.document = R"({"taxels":[]})";
  const std::int64_t number = store.add_fit(fit);
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  store.replace_verdicts(second, number, {verdict});
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
