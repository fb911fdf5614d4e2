// The thin wrapper itself: a bound value is read back, and a failing statement reports its error and leaves the wrapper
// usable.
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <new>
#include <optional>
#include <string>

#include "db/sqlite.h"
#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/child_process.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using Catch::Contains;
using db::sqlite::Access;
using db::sqlite::Connection;
using db::sqlite::Statement;
using db::sqlite::Transaction;

TEST_CASE("sqlite: a value too large for a store is refused before memory is allocated") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.disable_triggers_and_views();
  CHECK(store_error([&] { (void)connection.integer("SELECT length(zeroblob(300000000))"); }) == "TB-STORE-TOO-LARGE");
  CHECK(connection.integer("SELECT length(zeroblob(5000000))") == 5000000);
}

namespace {

void check_error(const std::string& id, const std::function<void()>& action) { CHECK(store_error(action) == id); }

}  // namespace

TEST_CASE("sqlite: a statement that failed or finished keeps no bound value") {
  Connection connection(":memory:", Access::kReadWrite);
  connection.execute("CREATE TABLE t (a INTEGER UNIQUE, b REAL, c TEXT, d BLOB)");
  Statement insert(connection, "INSERT INTO t VALUES (?, ?, ?, ?)");
  using Text = std::optional<std::string>;
  using Blob = std::optional<std::vector<double>>;
  const Text text = "word";
  const Blob blob = std::vector<double>{1.5};
  insert.bind(1, std::optional(2.5), text, blob).run();
  insert.bind(2, std::optional<double>{}, Text{}, Blob{}).run();
  check_error("TB-STORE-CONFLICT", [&] { insert.bind(2, std::optional(7.5), text, blob).run(); });
  insert.bind(3, std::optional<double>{}, Text{}, Blob{}).run();
  CHECK(connection.integer("SELECT count(*) FROM t WHERE b IS NULL AND c IS NULL AND d IS NULL") == 2);
  CHECK(connection.integer("SELECT a FROM t WHERE b = 2.5 AND c = 'word' AND length(d) = 8") == 1);
}

TEST_CASE("sqlite: NULL, an empty text and an empty blob are distinct") {
  Connection connection(":memory:", Access::kReadWrite);
  Statement row(connection, "SELECT typeof(?1), length(?1), typeof(?2), length(?2), ?3, ?4");
  row.bind(std::string_view(), std::vector<double>{}, std::nan(""), std::string("a\0b", 3));
  REQUIRE(row.step());
  std::string kind_of_text, kind_of_blob, text;
  int text_length = -1, blob_length = -1;
  double number = 0.0;
  row.read(kind_of_text, text_length, kind_of_blob, blob_length, number, text);
  CHECK((kind_of_text == "text" && text_length == 0 && kind_of_blob == "blob" && blob_length == 0));
  CHECK(std::isnan(number));
  CHECK(text == std::string("a\0b", 3));
  Statement nothing(connection, "SELECT NULL, NULL, NULL");
  REQUIRE(nothing.step());
  std::vector<double> values = {1.0};
  std::int64_t count = 7;
  nothing.read(text, values, count);
  CHECK((text.empty() && values.empty() && count == 0));
}

TEST_CASE("sqlite: an array receives the bytes of a blob, up to its own size") {
  Connection connection(":memory:", Access::kReadWrite);
  Statement row(connection, "SELECT x'0102', x'030405060708'");
  REQUIRE(row.step());
  struct {
    std::array<std::uint8_t, 4> few = {9, 9, 9, 9}, many = {9, 9, 9, 9}, behind = {9, 9, 9, 9};
  } got;
  row.read(got.few, got.many);
  CHECK(got.few == std::array<std::uint8_t, 4>{1, 2, 9, 9});
  CHECK(got.many == std::array<std::uint8_t, 4>{3, 4, 5, 6});
  CHECK(got.behind == std::array<std::uint8_t, 4>{9, 9, 9, 9});
}

TEST_CASE("sqlite: a query for a single value without a row is an error") {
  Connection connection(":memory:", Access::kReadWrite);
  CHECK(connection.integer("SELECT 41 + 1") == 42);
  CHECK(connection.text("SELECT 'a' || 'b'") == "ab");
  check_error("TB-STORE-SQL", [&] { (void)connection.integer("SELECT 1 WHERE 0"); });
  check_error("TB-STORE-SQL", [&] { (void)connection.text("SELECT 1 WHERE 0"); });
}

TEST_CASE("sqlite: a value beyond the library's size limit is refused when it is bound") {
  Connection connection(":memory:", Access::kReadWrite);
  sqlite3_limit(connection.handle(), SQLITE_LIMIT_LENGTH, 1000);
  Statement row(connection, "SELECT length(?)");
  const std::vector<std::uint8_t> bytes(1001);
  check_error("TB-STORE-TOO-LARGE", [&] { row.bind(std::string(1001, 'x')); });
  check_error("TB-STORE-TOO-LARGE", [&] { row.bind(bytes); });
  row.bind(std::string(990, 'x'));
  REQUIRE(row.step());
}

TEST_CASE("sqlite: a connection enforces foreign keys, trusts no schema and accepts no quoted name as a text") {
  Connection connection(":memory:", Access::kReadWrite);
  CHECK(connection.integer("PRAGMA foreign_keys") == 1);
  CHECK(connection.integer("PRAGMA trusted_schema") == 0);
  connection.execute("CREATE TABLE t (a)");
  check_error("TB-STORE-SQL", [&] { connection.execute("INSERT INTO t VALUES (\"no column\")"); });
  check_error("TB-STORE-SQL", [&] {
    connection.execute("PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = 'CREATE TABLE t (b)'");
  });
}

TEST_CASE("sqlite: writing through a read-only connection fails at once") {
  const TemporaryFolder folder;
  Connection(folder.path("a.db"), Access::kReadWrite).execute("CREATE TABLE t (a)");
  Connection reader(folder.path("a.db"), Access::kReadOnly);
  CHECK(reader.is_read_only());
  CHECK_FALSE(Connection(folder.path("a.db"), Access::kReadWrite).is_read_only());
  check_error("TB-STORE-OPEN", [&] { const Transaction transaction(reader); });
  CHECK_FALSE(reader.in_transaction());
  check_error("TB-STORE-OPEN", [&] { Connection(folder.path("none.db"), Access::kReadOnly); });
  CHECK_FALSE(std::filesystem::exists(folder.path("none.db")));
}

TEST_CASE("sqlite: special URI characters in a file name are used literally") {
  const TemporaryFolder folder;
  for (const std::string name : {"a?mode=memory.db", "a%41.db", "a#b.db", "a b&c=d.db", "Zz-_.~09\xc3\xa4.db"}) {
    CAPTURE(name);
    Connection(folder.path(name), Access::kReadWrite).execute("CREATE TABLE t (a); INSERT INTO t VALUES (7)");
    Connection still(folder.path(name), Access::kImmutable);
    CHECK(still.integer("SELECT a FROM t") == 7);
    CHECK_FALSE(store_error([&] { still.execute("INSERT INTO t VALUES (8)"); }).empty());
  }
}

TEST_CASE("sqlite: an uncommitted transaction is rolled back, a committed one is kept, and rows are counted") {
  const TemporaryFolder folder;
  Connection connection(folder.path("a.db"), Access::kReadWrite);
  connection.execute("CREATE TABLE t (a)");
  {
    const Transaction transaction(connection);
    CHECK(connection.in_transaction());
    connection.execute("INSERT INTO t VALUES (1)");
  }
  CHECK_FALSE(connection.in_transaction());
  CHECK(connection.integer("SELECT count(*) FROM t") == 0);
  {
    Transaction transaction(connection);
    connection.execute("INSERT INTO t VALUES (1), (2), (3)");
    CHECK(connection.changes() == 3);
    CHECK(connection.last_row() == 3);
    transaction.commit();
  }
  CHECK(Connection(folder.path("a.db"), Access::kReadOnly).integer("SELECT count(*) FROM t") == 3);
  {
    Transaction transaction(connection);  // a failure in it is the caller's to judge
    CHECK_FALSE(store_error([&] { connection.execute("INSERT INTO none VALUES (1)"); }).empty());
  }
  CHECK_FALSE(connection.in_transaction());
}

TEST_CASE("sqlite: a copy has all pages, and copying over a database in use fails") {
  const TemporaryFolder folder;
  Connection source(folder.path("a.db"), Access::kReadWrite), target(folder.path("b.db"), Access::kReadWrite, 0);
  source.execute("CREATE TABLE t (a); INSERT INTO t VALUES (zeroblob(100000))");
  source.copy_to(target);
  CHECK(target.integer("SELECT length(a) FROM t") == 100'000);
  CHECK(target.text("PRAGMA integrity_check") == "ok");
  {
    Connection other(folder.path("b.db"), Access::kReadWrite);
    const Transaction held(other);
    check_error("TB-STORE-LOCKED", [&] { source.copy_to(target); });
  }
  check_error("TB-STORE-SQL", [&] { source.copy_to(source); });
}

TEST_CASE("sqlite: each error code maps to the id of its kind, and the message states the code") {
  const Connection connection(":memory:", Access::kReadWrite);
  const std::map<std::string, std::vector<int>> known = {
      {"TB-STORE-FULL", {SQLITE_FULL}},
      {"TB-STORE-LOCKED", {SQLITE_BUSY, SQLITE_BUSY_SNAPSHOT, SQLITE_LOCKED, SQLITE_LOCKED_SHAREDCACHE}},
      {"TB-STORE-OPEN",
       {SQLITE_NOTADB, SQLITE_CORRUPT, SQLITE_CORRUPT_INDEX, SQLITE_READONLY, SQLITE_READONLY_DBMOVED,
        SQLITE_READONLY_ROLLBACK, SQLITE_PERM, SQLITE_AUTH, SQLITE_CANTOPEN, SQLITE_CANTOPEN_ISDIR}},
      {"TB-STORE-TOO-LARGE", {SQLITE_TOOBIG}},
      {"TB-STORE-CONFLICT", {SQLITE_CONSTRAINT, SQLITE_CONSTRAINT_UNIQUE}},
      {"TB-STORE-SQL", {SQLITE_ERROR, SQLITE_IOERR, SQLITE_IOERR_READ}}};
  for (const auto& [id, codes] : known) {
    for (const int code : codes) {
      CAPTURE(code);
      std::string message;
      CHECK(store_error([&, code = code] { connection.fail(code, "what was done"); }, &message) == id);
      CHECK_THAT(message, Contains("SQLite code " + std::to_string(code)));
    }
  }
  CHECK_THROWS_AS(connection.fail(SQLITE_NOMEM, "what was done"), std::bad_alloc);
}

TEST_CASE("sqlite: a second writer waits no longer than the timeout of its connection") {
  const TemporaryFolder folder;
  Connection holder(folder.path("a.db"), Access::kReadWrite), hasty(folder.path("a.db"), Access::kReadWrite, 1);
  CHECK(Connection(folder.path("a.db"), Access::kReadWrite).integer("PRAGMA busy_timeout") == 5000);
  CHECK(hasty.integer("PRAGMA busy_timeout") == 1);
  const auto wanted = [&] { const db::sqlite::Transaction transaction(hasty); };
  {
    const db::sqlite::Transaction held(holder);
    CHECK(store_error(wanted) == "TB-STORE-LOCKED");
  }
  CHECK(store_error(wanted).empty());
  hasty.wait_for_locks(2);
  CHECK(hasty.integer("PRAGMA busy_timeout") == 2);
}

TEST_CASE("store lock: the holder is named by program and process id, with and without WAL") {
  const TemporaryFolder folder;
  for (const char* journal : {"WAL", "DELETE"}) {
    const std::string path = folder.path(journal);
    Connection own(path, Access::kReadWrite, 1);
    own.execute(std::string("PRAGMA journal_mode = ") + journal + "; CREATE TABLE t (a)");
    const auto refused = [&] {
      std::string message;
      CHECK(store_error([&] { const db::sqlite::Transaction wanted(own); }, &message) == "TB-STORE-LOCKED");
      return message;
    };
    ChildProcess other({"/usr/bin/python3", "-c",
                        "import sqlite3, sys, time\nc = sqlite3.connect(sys.argv[1], isolation_level=None)\n"
                        "c.execute('BEGIN IMMEDIATE'); print('locked', flush=True); time.sleep(60)",
                        path});
    REQUIRE(other.line() == "locked");
    CHECK_THAT(refused(), Contains("python3 (pid " + std::to_string(other.pid()) + ")"));
    CHECK(db::writer_of(folder.path("another")).empty());
  }
}

TEST_CASE("sqlite: the first value of a query is that of its first row, and none without a row") {
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

TEST_CASE("sqlite: a statement that was reset starts again without its values") {
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
