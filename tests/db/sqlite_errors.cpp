// What SQLite's codes mean, code by code (sqlite.org/rescode.html), also for the extended codes that have the same
// lowest byte; and statements at their edges.
#include <sqlite3.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <optional>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using Catch::Contains;
using db::sqlite::Access;
using db::sqlite::Connection;
using db::sqlite::Statement;

TEST_CASE("each code of the database library has the id of its kind, and is told by its number") {
  const Connection connection(":memory:", Access::kReadWrite);
  const std::map<std::string, std::vector<int>> known = {
      {"TB-STORE-FULL", {SQLITE_FULL}},
      {"TB-STORE-LOCKED", {SQLITE_BUSY, SQLITE_BUSY_SNAPSHOT, SQLITE_LOCKED, SQLITE_LOCKED_SHAREDCACHE}},
      {"TB-STORE-OPEN",
       {SQLITE_NOTADB, SQLITE_CORRUPT, SQLITE_CORRUPT_INDEX, SQLITE_READONLY, SQLITE_READONLY_DBMOVED,
        SQLITE_READONLY_ROLLBACK, SQLITE_PERM, SQLITE_AUTH, SQLITE_CANTOPEN, SQLITE_CANTOPEN_ISDIR}},
      {"TB-STORE-TOO-LARGE", {SQLITE_TOOBIG}},
      {"TB-STORE-CONFLICT", {SQLITE_CONSTRAINT, SQLITE_CONSTRAINT_UNIQUE}},
      {"TB-STORE-SQL", {SQLITE_ERROR, SQLITE_IOERR, SQLITE_IOERR_READ, SQLITE_NOMEM}}};
  for (const auto& [id, codes] : known) {
    for (const int code : codes) {
      CAPTURE(code);
      std::string message;
      CHECK(store_error([&, code = code] { connection.fail(code, "what was done"); }, &message) == id);
      CHECK_THAT(message, Contains("SQLite code " + std::to_string(code)));
    }
  }
}

TEST_CASE("a second writer waits no longer than its connection was told") {
  const TemporaryFolder folder;
  Connection holder(folder.path("a.db"), Access::kReadWrite), hasty(folder.path("a.db"), Access::kReadWrite, 1);
  CHECK(Connection(folder.path("a.db"), Access::kReadWrite).integer("PRAGMA busy_timeout") == 5000);
  CHECK(hasty.integer("PRAGMA busy_timeout") == 1);
  const db::sqlite::Transaction held(holder);
  CHECK(store_error([&] { const db::sqlite::Transaction wanted(hasty); }) == "TB-STORE-LOCKED");
}

TEST_CASE("the first value of a query is that of its first row, and of no row there is none") {
  Connection connection(":memory:", Access::kReadWrite);
  CHECK(Statement(connection, "VALUES (7), (8)").first<int>() == 7);
  CHECK(Statement(connection, "VALUES ('a')").first<std::string>() == "a");
  CHECK_FALSE(Statement(connection, "SELECT 7 WHERE 0").first<int>());
  Statement row(connection, "SELECT 1, NULL, 2.5, 'text'");
  REQUIRE(row.step());
  CHECK((row.value<int>() == 1 && row.value<double>(2) == 2.5 && row.value<std::string>(3) == "text"));
  std::optional<double> none = 1.0, some;
  row.read_from(1, none, some);
  CHECK((!none && some == 2.5));
  CHECK((row.is_null(1) && !row.is_null(0)));
}

TEST_CASE("a statement that was reset begins anew without its values") {
  Connection connection(":memory:", Access::kReadWrite);
  Statement row(connection, "SELECT ?1 UNION ALL SELECT ?1");
  row.bind(5);
  REQUIRE(row.step());
  row.reset();
  REQUIRE(row.step());
  CHECK(row.is_null(0));
  row.run();
  CHECK(row.bind(6).first<int>() == 6);
}

TEST_CASE("a copy over a database that others use, or over itself, is refused") {
  const TemporaryFolder folder;
  Connection source(folder.path("a.db"), Access::kReadWrite), target(folder.path("b.db"), Access::kReadWrite, 0);
  source.execute("CREATE TABLE t (a)");
  target.execute("CREATE TABLE u (a)");
  Connection other(folder.path("b.db"), Access::kReadWrite);
  const db::sqlite::Transaction held(other);
  CHECK(store_error([&] { source.copy_to(target); }) == "TB-STORE-LOCKED");
  CHECK(store_error([&] { source.copy_to(source); }) == "TB-STORE-SQL");
}
