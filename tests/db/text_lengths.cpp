// Texts that people enter have a bounded length, and longer ones are refused before anything is stored.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <exception>
#include <filesystem>

#include "bench/common/error.h"
#include "db/remarks.h"
#include "db/run_store.h"
#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"
#include "tests/db/store_example.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::string umlauts(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += "ä";
  return text;
}

}  // namespace

TEST_CASE("run store: names, purposes, notes and reasons have a maximum length in characters") {
  NewStore store;
  const std::string name(db::kMaxNameLength + 1, 'n'), text(db::kMaxTextLength + 1, 't');
  const auto refused = [](auto action) { CHECK(store_error(action) == "TB-STORE-TOO-LONG"); };
  db::SensorRecord sensor = example_sensor();
  sensor.note = text;
  refused([&] { store.add_sensor(sensor); });
  for (const char* odd : {"\xff", "S\xc3", "\xc0\xaf", "\xed\xa0\x80", "\xe0\x80\xaf", "\xf4\x90\x80\x80", "\x80"}) {
    sensor = example_sensor();
    sensor.serial = odd;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-NOT-TEXT");
  }
  CHECK(store.sensors().empty());
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.operator_name = umlauts(db::kMaxNameLength);
  record.purpose = text;
  refused([&] { store.begin_run(record); });
  CHECK(store.runs().empty());
  record.purpose = umlauts(db::kMaxTextLength);
  CHECK(store.begin_run(record) == 1);
  const std::int64_t run = store_example(store);
  refused([&] { store.add_note(run, text); });
  refused([&] { store.void_run(run, text, "me", "2026"); });
  refused([&] { store.void_run(run, "why", name, "2026"); });
  refused([&] { store.add_report({run, "1-a", "a", name, "2026", "", ""}); });
  store.replace_figures(run, "rig", {{"x_psi", 1.0}});
  refused([&] { store.add_baseline({0, "rig", text, "me", "2026", {run}}); });
  refused([&] { store.add_baseline({0, "rig", "why", name, "2026", {run}}); });
  const db::RunRecord stored = store.run(run);
  CHECK((stored.notes.empty() && !stored.is_void() && store.reports(run).empty() && store.baselines().empty()));
}

TEST_CASE("run store: names without a visible character are refused as blank") {
  NewStore store;
  for (const char* blank : {" ", "\t\n", "\u00a0\u2003", "\u200b", "\ufeff\u3000"}) {
    db::SensorRecord sensor = example_sensor();
    sensor.serial = blank;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-BLANK");
    sensor = example_sensor();
    sensor.scanner_serial = blank;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-BLANK");
    CHECK(db::is_blank(blank));
  }
  CHECK(store.sensors().empty());
  db::SensorRecord any_scanner = example_sensor();
  any_scanner.serial = "\u00a0S 1";
  any_scanner.scanner_serial = "";
  store.add_sensor(any_scanner);
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.operator_name = "  ";
  CHECK(store_error([&] { store.begin_run(record); }) == "TB-STORE-BLANK");
  record.operator_name = "";  // of an imported table nobody need be known
  CHECK(store.begin_run(record) == 1);
  CHECK((db::is_blank("") && !db::is_blank("\xff") && !db::is_blank(" \u00fc ")));
}

TEST_CASE("run store: device texts have a maximum length and must be UTF-8, otherwise nothing is stored") {
  NewStore store;
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.devices.clear();
  const std::int64_t run = store.begin_run(record);
  const std::string name(db::kMaxNameLength + 1, 'n');
  for (std::string db::DeviceRecord::*field :
       {&db::DeviceRecord::model, &db::DeviceRecord::serial, &db::DeviceRecord::firmware}) {
    db::DeviceRecord device{"tactile scanner", "M", "S", "1", "simulated", "{}"};
    for (const auto& [text, id] :
         {std::pair(name, "TB-STORE-TOO-LONG"), std::pair(std::string("S\xff"), "TB-STORE-NOT-TEXT")}) {
      device.*field = text;
      CHECK(store_error([&] { store.set_devices(run, {device}); }) == id);
      record.devices = {device};
      CHECK(store_error([&] { store.begin_run(record); }) == id);
    }
    device.*field = umlauts(db::kMaxNameLength);
    store.set_devices(run, {device});
    CHECK(store.run(run).devices.front().*field == umlauts(db::kMaxNameLength));
  }
  CHECK(store.runs().size() == 1);
}

TEST_CASE("run store: a run has at most a hundred tags") {
  NewStore store;
  const std::int64_t run = store_example(store);
  std::vector<std::string> tags;
  for (std::size_t i = 0; i < db::kMaxTags; ++i) tags.push_back("tag" + std::to_string(i));
  store.set_tags(run, tags, {});
  CHECK(store_error([&] { store.set_tags(run, {"one-more"}, {}); }) == "TB-STORE-TAG");
  CHECK(store.run(run).tags.size() == db::kMaxTags);
  store.set_tags(run, {"one-more"}, {"tag0"});
}

TEST_CASE("run store: a text that is too long is a usage error, not damage of the store") {
  std::exception_ptr thrown;
  try {
    db::check_text("the note", std::string(db::kMaxTextLength + 1, 't'), db::kMaxTextLength);
  } catch (...) {
    thrown = std::current_exception();
  }
  REQUIRE(thrown);
  CHECK(bench::as_error(thrown).id() == "TB-STORE-TOO-LONG");
  CHECK(bench::as_error(thrown).code() == bench::ExitCode::kUsage);
}

// The write-ahead log of a durable run has its full length at the first frame: commits then write over it, which needs
// no commit of the file system's journal.

using namespace tactbench::db;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr std::uintmax_t kFullLog = 1000 * (4096 + 24) + 32;

}  // namespace

TEST_CASE("write-ahead log: is preallocated for a durable run, and frames overwrite it without lengthening it") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path, Durability::kFull);
  const auto [run, branch] = begin_example(store);
  const std::uintmax_t length = std::filesystem::file_size(path + "-wal");
  CHECK(length >= kFullLog);
  for (int i = 0; i < 50; ++i) store.append_frame(run, example_frame(branch, i));
  CHECK(std::filesystem::file_size(path + "-wal") == length);
  const RunStore reader = RunStore::open_read_only(path);  // a rolled-back transaction has no content
  CHECK(reader.frame_count(run) == 50);
  CHECK(reader.check_structure().empty());
  store.end_run(run, Outcome::kCompleted, "", SafeState::kVerified, "");
  CHECK(store.check_content(run).holds());
}

TEST_CASE("write-ahead log: is not preallocated for a run of normal durability") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), Durability::kNormal);
  begin_example(store);
  CHECK(std::filesystem::file_size(folder.path("runs.db-wal")) < 400'000);
}

TEST_CASE("write-ahead log: opening a store in rollback-journal mode waits for a reader, then switches to WAL") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  REQUIRE(Connection(path, Access::kReadWrite).text("PRAGMA journal_mode = DELETE") == "delete");
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    Connection reader(path, Access::kReadOnly);
    reader.execute("BEGIN");
    const bool read = reader.integer("SELECT count(*) FROM runs") == 0;
    if (write(ends[1], "r", 1) != 1) _exit(2);
    usleep(100'000);
    reader.execute("COMMIT");
    _exit(read ? 0 : 1);
  }
  char byte = 0;
  REQUIRE(read(ends[0], &byte, 1) == 1);
  std::string message;
  CHECK(store_error([&] { RunStore::open(path); }, &message).empty());
  CAPTURE(message);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  for (const int end : ends) close(end);
  CHECK(Connection(path, Access::kReadWrite).text("PRAGMA journal_mode") == "wal");
}

TEST_CASE("library versions: SQLite and OpenSSL are named with their versions") {
  const auto versions = db::library_versions();
  REQUIRE(versions.size() == 2);
  CHECK((versions[0].first == "SQLite" && versions[0].second.starts_with("3.")));
  CHECK((versions[1].first == "OpenSSL" && versions[1].second.find('.') != std::string::npos));
}

// Tables, indexes, views and triggers that tactbench did not make: reported, and never executed.

namespace {

struct Changed {
  std::string written, read;  // identifiers of the errors of opening for each
  std::string message;
  std::vector<std::string> structure;  // where reading is possible
};

// A store with one run after `sql` was carried out on it.
Changed changed_by(const std::string& sql) {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    store_example(store);
  }
  Connection(path, Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  const std::string before = read_file(path);
  Changed changed;
  changed.written = store_error([&] { RunStore::open(path); }, &changed.message);
  changed.read = store_error([&] {
    const RunStore store = RunStore::open_read_only(path);
    CHECK(store.check_content(1).holds());
    CHECK(store.frames(1).size() == 3);
    changed.structure = store.check_structure();
  });
  CHECK(read_file(path) == before);
  return changed;
}

}  // namespace

TEST_CASE("foreign objects: foreign triggers, tables, indexes and views are named, and the store is not written") {
  const auto refused = [](const std::string& sql, const std::string& named) {
    const Changed changed = changed_by(sql);
    INFO(sql);
    CHECK(changed.written == "TB-STORE-FOREIGN");
    CHECK_THAT(changed.message, Catch::Contains(named));
    CHECK(changed.read.empty());
    REQUIRE(changed.structure.size() == 1);
    CHECK_THAT(changed.structure.front(), Catch::Contains(named));
  };
  refused("CREATE TRIGGER evil AFTER INSERT ON runs BEGIN DELETE FROM verdicts; END", "'evil'");
  refused("CREATE TABLE mine (a)", "'mine'");
  refused("CREATE INDEX quick ON frames (time_ns)", "'quick'");
  refused("CREATE VIEW v_mine AS SELECT 1", "'v_mine'");
}

TEST_CASE("foreign objects: if a table, index or view of the store itself differs, reading is refused too") {
  const auto refused = [](const std::string& sql, const std::string& named) {
    const Changed changed = changed_by(sql);
    INFO(sql);
    CHECK(changed.written == "TB-STORE-OTHER-SCHEMA");
    CHECK(changed.read == "TB-STORE-OTHER-SCHEMA");
    CHECK_THAT(changed.message, Catch::Contains(named));
  };
  refused("DROP VIEW v_runs; CREATE VIEW v_runs AS SELECT 1 AS run", "'v_runs'");
  refused("DROP INDEX verdicts_of_run", "'verdicts_of_run'");
  refused(
      "DROP VIEW v_frames; DROP VIEW v_runs; DROP TABLE frames; CREATE VIEW frames AS WITH RECURSIVE c (frame) AS "
      "(SELECT 1 UNION ALL SELECT frame + 1 FROM c) SELECT frame FROM c",
      "'frames'");
  refused("ALTER TABLE verdicts ADD COLUMN more TEXT", "'verdicts'");
}

TEST_CASE("foreign objects: SQLite's own statistics are not foreign") {
  const Changed changed = changed_by("ANALYZE");
  CHECK((changed.written.empty() && changed.read.empty() && changed.structure.empty()));
}

TEST_CASE("foreign objects: no trigger runs and no view is read on an untrusted schema") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.execute(
      "CREATE TABLE a (x); CREATE TABLE b (x); CREATE VIEW c AS SELECT x FROM a; "
      "CREATE TRIGGER t AFTER INSERT ON a BEGIN INSERT INTO b VALUES (1); END");
  connection.disable_triggers_and_views();
  connection.execute("INSERT INTO a VALUES (7)");
  CHECK(connection.integer("SELECT count(*) FROM b") == 0);
  CHECK_FALSE(store_error([&] { (void)connection.integer("SELECT x FROM c"); }).empty());
}

TEST_CASE("sqlite: a value too large for a store is refused before memory is allocated") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.disable_triggers_and_views();
  CHECK(store_error([&] { (void)connection.integer("SELECT length(zeroblob(300000000))"); }) == "TB-STORE-TOO-LARGE");
  CHECK(connection.integer("SELECT length(zeroblob(5000000))") == 5000000);
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
