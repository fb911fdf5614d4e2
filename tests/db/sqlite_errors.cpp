// What SQLite's codes mean to a person: the name of the error, what happened and what to do, code by code
// (sqlite.org/rescode.html), also for the extended codes that have the same lowest byte.
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

namespace {

struct Known {
  int code;
  const char* id;
  const char* what;
  const char* remedy;
};

}  // namespace

TEST_CASE("each code of the database library has its name, its words and its remedy") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const Connection connection(path, Access::kReadWrite);
  for (const Known& known : std::vector<Known>{
           {SQLITE_FULL, "TB-STORE-FULL", "there is no room left", "free space on the disk"},
           {SQLITE_BUSY, "TB-STORE-LOCKED", "another process is writing", "see who holds it (fuser FILE)"},
           {SQLITE_BUSY_SNAPSHOT, "TB-STORE-LOCKED", "another process is writing", "try again"},
           {SQLITE_LOCKED, "TB-STORE-LOCKED", "another process is writing", "try again"},
           {SQLITE_LOCKED_SHAREDCACHE, "TB-STORE-LOCKED", "another process is writing", "try again"},
           {SQLITE_NOTADB, "TB-STORE-OPEN", "this is not a store of tactbench", "name another file"},
           {SQLITE_CORRUPT, "TB-STORE-OPEN", "the file is damaged", "take your last snapshot"},
           {SQLITE_CORRUPT_INDEX, "TB-STORE-OPEN", "the file is damaged", ".recover"},
           {SQLITE_READONLY, "TB-STORE-OPEN", "may not be written by this user", "owner and permissions"},
           {SQLITE_READONLY_DBMOVED, "TB-STORE-OPEN", "may not be written by this user", "owner and permissions"},
           {SQLITE_READONLY_ROLLBACK, "TB-STORE-OPEN", "was killed, and half of that is in the file", "db migrate"},
           {SQLITE_PERM, "TB-STORE-OPEN", "may not be written by this user", "owner and permissions"},
           {SQLITE_AUTH, "TB-STORE-OPEN", "may not be written by this user", "owner and permissions"},
           {SQLITE_CANTOPEN, "TB-STORE-OPEN", "the file cannot be opened", "check path"},
           {SQLITE_CANTOPEN_ISDIR, "TB-STORE-OPEN", "the file cannot be opened", "check path"},
           {SQLITE_TOOBIG, "TB-STORE-TOO-LARGE", "larger than a store takes", "less in one piece"},
           {SQLITE_CONSTRAINT, "TB-STORE-CONFLICT", "contradicts what is stored", "check the values"},
           {SQLITE_CONSTRAINT_UNIQUE, "TB-STORE-CONFLICT", "contradicts what is stored", "check the values"},
           {SQLITE_ERROR, "TB-STORE-SQL", "the database library refused", "please report this"},
           {SQLITE_IOERR, "TB-STORE-SQL", "the database library refused", "check the disk"},
           {SQLITE_IOERR_READ, "TB-STORE-SQL", "the database library refused", "check the disk"},
           {SQLITE_NOMEM, "TB-STORE-SQL", "the database library refused", "check the disk"}}) {
    CAPTURE(known.code);
    std::string message;
    CHECK(store_error([&] { connection.fail(known.code, "what was done"); }, &message) == known.id);
    CHECK_THAT(message, Contains(known.what) && Contains(known.remedy));
    // No file failed: the system's own words do not follow those of the library.
    CHECK_THAT(message, Contains("store " + path + ": ") &&
                            Contains("(" + std::string(sqlite3_errstr(known.code)) + ", SQLite code " +
                                     std::to_string(known.code) + "; what was done) | "));
  }
}

TEST_CASE("a database in memory that fails names no failure of a file") {
  const Connection connection(":memory:", Access::kReadWrite);
  std::string message;
  CHECK(store_error([&] { connection.fail(SQLITE_CANTOPEN, "open"); }, &message) == "TB-STORE-OPEN");
  CHECK_THAT(message, Contains(", SQLite code 14; open)") && !Contains(std::strerror(EPERM)));
}

TEST_CASE("a file that cannot be opened has the library's code and the system's reason") {
  const TemporaryFolder folder;
  std::string message;
  CHECK(store_error([&] { const Connection none(folder.path("none.db"), Access::kReadOnly); }, &message) ==
        "TB-STORE-OPEN");
  CHECK_THAT(message, Contains("the file cannot be opened") && Contains(std::strerror(ENOENT)) &&
                          Contains("SQLite code 14; open)"));
}

TEST_CASE("an error that is the connection's own has its own words, and one of another kind has the library's") {
  Connection connection(":memory:", Access::kReadWrite);
  CHECK_FALSE(store_error([&] { connection.execute("SELECT absent"); }).empty());
  std::string message;
  store_error([&] { connection.fail(SQLITE_ERROR, "again"); }, &message);
  CHECK_THAT(message, Contains("no such column: absent"));
  store_error([&] { connection.fail(SQLITE_FULL, "again"); }, &message);
  CHECK_THAT(message, !Contains("no such column") && Contains(sqlite3_errstr(SQLITE_FULL)));
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

TEST_CASE("a copy over a database that others use is told with both files") {
  const TemporaryFolder folder;
  Connection source(folder.path("a.db"), Access::kReadWrite), target(folder.path("b.db"), Access::kReadWrite, 0);
  source.execute("CREATE TABLE t (a)");
  target.execute("CREATE TABLE u (a)");
  Connection other(folder.path("b.db"), Access::kReadWrite);
  const db::sqlite::Transaction held(other);
  std::string message;
  CHECK(store_error([&] { source.copy_to(target); }, &message) == "TB-STORE-LOCKED");
  CHECK_THAT(message, Contains("store " + folder.path("b.db")) && Contains("copy of " + folder.path("a.db")));
  CHECK(store_error([&] { source.copy_to(source); }, &message) == "TB-STORE-SQL");
  CHECK_THAT(message, Contains("begin a copy"));
}
