// Copies of a store that another process is writing, and checks of the file.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <csignal>
#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("a snapshot of a store with a live run holds the acknowledged frames, and neither is disturbed") {
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

TEST_CASE("a snapshot overwrites nothing, and a failed one leaves nothing") {
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

TEST_CASE("a snapshot without free space ends with TB-STORE-FULL and leaves nothing") {
  const TemporaryFolder folder;
  {
    RunStore store = RunStore::open(folder.path("runs.db"));
    store_example(store);
  }
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const RunStore store = RunStore::open_read_only(folder.path("runs.db"));
    const rlimit limit{50'000, 50'000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
    const std::string id = store_error([&] { store.snapshot(folder.path("no.db")); });
    _exit(id == "TB-STORE-FULL" ? 0 : 1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  for (const char* ending : {"", ".partial", ".partial-journal", ".partial-wal"}) {
    CHECK_FALSE(std::filesystem::exists(folder.path("no.db") + ending));
  }
}

TEST_CASE("the structure check names rows that point nowhere and broken constraints") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  CHECK(store.check_structure().empty());
  Connection raw(folder.path("runs.db"), Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON");
  raw.execute("UPDATE events SET run = 9 WHERE event = 2");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Catch::Contains("row 2 of events"));
  raw.execute("UPDATE runs SET outcome = 'done'");
  CHECK(store.check_structure().size() == 2);
}
