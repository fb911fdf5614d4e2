// The first switch of a store to its write-ahead log, while another process still reads the file.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "db/library_versions.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("a store without a log waits for who reads it, and then has its log") {
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

TEST_CASE("the libraries of the room are named with their versions") {
  const auto versions = db::library_versions();
  REQUIRE(versions.size() == 2);
  CHECK((versions[0].first == "SQLite" && versions[0].second.starts_with("3.")));
  CHECK((versions[1].first == "OpenSSL" && versions[1].second.find('.') != std::string::npos));
}
