// Tables, indexes, views and triggers that tactbench did not make: reported, and never executed.
#include <catch2/catch.hpp>
#include <filesystem>

#include "db/schema.h"
#include "tests/db/new_store.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

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

TEST_CASE("foreign triggers, tables, indexes and views are named, and a store with them is not written") {
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

TEST_CASE("where one of the store's own tables or views differs, reading is refused, too, and at once") {
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

TEST_CASE("SQLite's own statistics do not count as foreign objects") {
  const Changed changed = changed_by("ANALYZE");
  CHECK((changed.written.empty() && changed.read.empty() && changed.structure.empty()));
}

TEST_CASE("no trigger of a store fires and no view of it is read") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.execute(
      "CREATE TABLE a (x); CREATE TABLE b (x); CREATE VIEW c AS SELECT x FROM a; "
      "CREATE TRIGGER t AFTER INSERT ON a BEGIN INSERT INTO b VALUES (1); END");
  connection.trust_no_schema();
  connection.execute("INSERT INTO a VALUES (7)");
  CHECK(connection.integer("SELECT count(*) FROM b") == 0);
  CHECK_FALSE(store_error([&] { (void)connection.integer("SELECT x FROM c"); }).empty());
}

TEST_CASE("a value too large for a store is refused before memory is taken") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.trust_no_schema();
  CHECK(store_error([&] { (void)connection.integer("SELECT length(zeroblob(300000000))"); }) == "TB-STORE-TOO-LARGE");
  CHECK(connection.integer("SELECT length(zeroblob(5000000))") == 5000000);
}

TEST_CASE("frames whose counts do not fit their shape are not returned") {
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
