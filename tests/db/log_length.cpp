// The write-ahead log of a durable run has its full length at the first frame: commits then write over it, which needs
// no commit of the file system's journal.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "db/library_versions.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench::db;
using namespace tactbench::tests;
using namespace tactbench;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr std::uintmax_t kFullLog = 1000 * (4096 + 24) + 32;

}  // namespace

TEST_CASE("a durable run writes over its log and does not lengthen it") {
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

TEST_CASE("a run under the turned clock does not lengthen the log") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), Durability::kNormal);
  begin_example(store);
  CHECK(std::filesystem::file_size(folder.path("runs.db-wal")) < 400'000);
}

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
