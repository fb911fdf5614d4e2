// Findings of the content check for a run that is short, open, or changed in several places; and for a store.
#include <catch2/catch.hpp>

#include "db/schema.h"
#include "db/sqlite.h"
#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

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

using Catch::Contains;

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

TEST_CASE("store opening: tables without a version and extra bytes are damage, an empty database is new") {
  Connection connection(":memory:", Access::kReadWrite);
  CHECK(store_error([&] { db::check_version(connection); }).empty());
  connection.execute("CREATE TABLE mine (a)");
  CHECK(store_error([&] { db::check_version(connection); }) == "TB-STORE-OPEN");
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  const std::string whole = read_file(path);
  write_file(path, whole + "x");
  CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OPEN");
  write_file(path, whole);
  CHECK(store_error([&] { RunStore::open(path); }).empty());
}

TEST_CASE("store migration: a third backup also gets a name of its own") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup");
  write_file(path + ".schema-3.backup", "");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup.2");
  write_file(path + ".schema-3.backup.2", "");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup.3");
  CHECK(db::backup_path(path, 4) == path + ".schema-4.backup");
}
