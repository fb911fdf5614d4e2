// Opening a store, the write-ahead log of a durable run, and disks that are full or fail.
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/child_process.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using db::Durability;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

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

TEST_CASE("write-ahead log: a log of exactly 1000 pages is kept, one a byte shorter is lengthened") {
  // A write-ahead log is a header of 32 bytes, then 24 bytes and a page for each page that it holds.
  for (const std::uintmax_t length : {1000 * (4096 + 24) + 32 - 1, 1000 * (4096 + 24) + 32}) {
    const TemporaryFolder folder;
    const std::string log = folder.path("runs.db-wal");
    RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kFull);
    store.add_sensor(example_sensor());
    std::filesystem::resize_file(log, length);
    store.begin_run(example_run());
    CHECK((std::filesystem::file_size(log) == length) == (length == 1000 * (4096 + 24) + 32));
  }
}

TEST_CASE("run store: several processes may create one store at once and write to it at once") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  constexpr int kWriters = 6;
  constexpr int kFrames = 30;
  std::vector<pid_t> children;
  for (int i = 0; i < kWriters; ++i) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      std::string why;
      const std::string id = store_error(
          [&] {
            RunStore store = RunStore::open(path, Durability::kNormal);
            const Begun begun = begin_example(store);
            for (int f = 0; f < kFrames; ++f) store.append_frame(begun.run, example_frame(begun.branch, f));
            store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
          },
          &why);
      if (!id.empty()) std::fprintf(stderr, "%s %s\n", id.c_str(), why.c_str());
      _exit(id.empty() ? 0 : 1);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  }
  const RunStore store = RunStore::open_read_only(path);
  const std::vector<db::RunRecord> runs = store.runs();
  REQUIRE(runs.size() == kWriters);
  for (const db::RunRecord& run : runs) {
    CHECK(store.frame_count(run.run) == kFrames);
    CHECK(run.content_sha256 == runs.front().content_sha256);
    CHECK(store.content_hash(run.run) == run.content_sha256);
  }
}

// The write-ahead log of a durable run has its full length at the first frame: commits then write over it, which needs
// no commit of the file system's journal.

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

namespace {

// Refused with `id` by both ways of opening, and not one byte of the folder changed.
void check_opening(const TemporaryFolder& folder, const std::string& id) {
  const std::string path = folder.path("runs.db");
  const std::string before = read_file(path);
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == id);
  CHECK(store_error([&] { RunStore::open(path); }) == id);
  CHECK(read_file(path) == before);
}

}  // namespace

TEST_CASE("store opening: a store with a later schema is refused, for reading and for writing") {
  const TemporaryFolder folder;
  RunStore::open(folder.path("runs.db"));
  Connection(folder.path("runs.db"), Access::kReadWrite).execute("PRAGMA user_version = 9999");
  check_opening(folder, "TB-STORE-OTHER-SCHEMA");
}

TEST_CASE("store opening: a database of another program is refused and left unchanged") {
  const TemporaryFolder folder;
  Connection(folder.path("runs.db"), Access::kReadWrite)
      .execute("PRAGMA journal_mode = WAL; CREATE TABLE runs (a); PRAGMA user_version = 1");
  check_opening(folder, "TB-STORE-OPEN");
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db-wal")));
}

TEST_CASE("store opening: a file that is not a database is refused") {
  const TemporaryFolder folder;
  RunStore::open(folder.path("good.db"));
  const std::string good = read_file(folder.path("good.db"));
  // The last two: a valid header without its last byte, alone, and before other bytes.
  for (const std::string& text : {std::string(5000, 'x'), std::string("short"), std::string("x"), good.substr(0, 99),
                                  good.substr(0, 100), good.substr(0, 100) + std::string(8092, 'x')}) {
    write_file(folder.path("runs.db"), text);
    check_opening(folder, "TB-STORE-OPEN");
  }
}

TEST_CASE("store opening: a missing folder, a folder instead of a file and an empty name are refused") {
  const TemporaryFolder folder;
  CHECK(store_error([&] { RunStore::open(folder.path("none/runs.db")); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { RunStore::open(folder.path()); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { RunStore::open(""); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { RunStore::open_read_only(folder.path("runs.db")); }) == "TB-STORE-OPEN");
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db")));
  write_file(folder.path("runs.db"), "");
  CHECK(store_error([&] { RunStore::open_read_only(folder.path("runs.db")); }) == "TB-STORE-OPEN");
  CHECK(store_error([&] { RunStore::open(folder.path("runs.db")); }).empty());  // an empty file may become a store
}

TEST_CASE("store opening: folders, devices and pipes are refused, for reading and for writing") {
  const TemporaryFolder folder;
  const std::string pipe = folder.path("pipe"), inner = folder.path("inner");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  REQUIRE(std::filesystem::create_directory(inner));
  for (const std::string& path : {inner, pipe, std::string("/dev/null"), std::string("/dev/zero")}) {
    CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN");
  }
}

TEST_CASE("store opening: reading never writes, and does not recover the log of a dead writer") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  REQUIRE(in_child([&] {
            store_example(*new RunStore(RunStore::open(path)));  // never closed: the log stays
            return 0;
          }) == 0);
  const std::string file = read_file(path), log = read_file(path + "-wal");
  REQUIRE_FALSE(log.empty());
  {
    RunStore reader = RunStore::open_read_only(path);
    CHECK(reader.frame_count(1) == 3);
    CHECK(reader.content_hash(1) == reader.run(1).content_sha256);
    db::SensorRecord other = example_sensor();
    other.serial = "S-2";
    CHECK(store_error([&] { reader.add_sensor(other); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { reader.begin_run(example_run()); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { (void)reader.mark_interrupted(""); }) == "TB-STORE-OPEN");
  }
  CHECK(read_file(path) == file);
  CHECK(read_file(path + "-wal") == log);
}

TEST_CASE("store opening: without write permission, writing is refused and reading works") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    store_example(store);
  }
  const auto as_user = [&](mode_t folder_mode, bool write) {
    chmod(path.c_str(), 0444);
    chmod(folder.path().c_str(), folder_mode);
    const int code = in_child([&] {
      if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) return 3;
      if (write) return store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN" ? 0 : 1;
      bool read = false;
      const std::string id = store_error([&] { read = RunStore::open_read_only(path).frame_count(1) == 3; });
      return id.empty() && read ? 0 : 2;
    });
    chmod(folder.path().c_str(), 0755);
    return code;
  };
  CHECK(as_user(0777, true) == 0);
  CHECK(as_user(0555, true) == 0);
  CHECK(as_user(0777, false) == 0);
  CHECK(as_user(0555, false) == 0);
}

TEST_CASE("sqlite: a database that may not grow is reported as a full store") {
  const TemporaryFolder folder;
  Connection small(folder.path("small.db"), Access::kReadWrite);
  small.execute("PRAGMA max_page_count = 4; CREATE TABLE t (b BLOB)");
  CHECK(store_error([&] { small.execute("INSERT INTO t VALUES (zeroblob(50000))"); }) == "TB-STORE-FULL");
}

// The system's limit on file size stands in for a full disk: the same failed write, without a disk of its own.
TEST_CASE("run store: if the disk is full during a run, the frame is refused and all earlier ones are kept") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  int pipe_ends[2];
  REQUIRE(pipe(pipe_ends) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    int acknowledged = 0;
    std::string id;
    {
      RunStore store = RunStore::open(path, db::Durability::kNormal);
      const Begun begun = begin_example(store);
      const rlimit limit{400'000, 400'000};
      if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
      id = store_error([&] {
        for (; acknowledged < 5000; ++acknowledged) {
          store.append_frame(begun.run, example_frame(begun.branch, acknowledged));
        }
      });
      // It stays full, and reports it again rather than storing over a gap.
      const auto again = store_error([&] { store.append_frame(begun.run, example_frame(begun.branch, 9999)); });
      if (again != "TB-STORE-FULL") _exit(3);
    }
    if (write(pipe_ends[1], &acknowledged, sizeof acknowledged) != sizeof acknowledged) _exit(4);
    _exit(id == "TB-STORE-FULL" ? 0 : 1);
  }
  close(pipe_ends[1]);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  int acknowledged = 0;
  REQUIRE(read(pipe_ends[0], &acknowledged, sizeof acknowledged) == sizeof acknowledged);
  close(pipe_ends[0]);
  CHECK(acknowledged > 50);
  RunStore store = RunStore::open(path);
  CHECK(store.frame_count(1) == acknowledged);
  CHECK(store.mark_interrupted("2024-05-01T11:00:00Z") == 1);
  CHECK(store.content_hash(1) == store.run(1).content_sha256);
}

// A file that cannot be written, by the operating system's own number for why: SQLite is given a write that fails.

namespace {

int failing_with = 0;

ssize_t write_fails(int /*file*/, const void* /*bytes*/, std::size_t /*count*/) {
  errno = failing_with;
  return -1;
}
ssize_t write_at_fails(int file, const void* bytes, std::size_t count, off_t /*at*/) {
  return write_fails(file, bytes, count);
}

// SQLite's own way to test this (sqlite3_vfs::xSetSystemCall): its writes fail while this lives.
class FailingWrites {
 public:
  explicit FailingWrites(int number) : vfs_(sqlite3_vfs_find(nullptr)) {
    failing_with = number;
    set("write", reinterpret_cast<sqlite3_syscall_ptr>(write_fails));
    for (const char* call : {"pwrite", "pwrite64"}) set(call, reinterpret_cast<sqlite3_syscall_ptr>(write_at_fails));
  }
  ~FailingWrites() {
    for (const char* call : {"write", "pwrite", "pwrite64"}) set(call, nullptr);
  }
  FailingWrites(const FailingWrites&) = delete;
  FailingWrites& operator=(const FailingWrites&) = delete;

 private:
  void set(const char* call, sqlite3_syscall_ptr function) {
    if (vfs_->xGetSystemCall(vfs_, call) != nullptr) vfs_->xSetSystemCall(vfs_, call, function);
  }
  sqlite3_vfs* vfs_;
};

std::string failed_with(int number, std::string* message) {
  const TemporaryFolder folder;
  Connection connection(folder.path("runs.db"), Access::kReadWrite);
  connection.execute("PRAGMA journal_mode = WAL; CREATE TABLE t (a)");
  std::string id;
  {
    const FailingWrites failing(number);
    id = store_error([&] { connection.execute("INSERT INTO t VALUES (1)"); }, message);
  }
  connection.execute("INSERT INTO t VALUES (2)");  // as soon as there is room again
  CHECK(connection.integer("SELECT sum(a) FROM t") == 2);
  return id;
}

}  // namespace

TEST_CASE("store write failure: a full disk, a full quota and a file size limit are reported as a full store") {
  for (const int number : {ENOSPC, EDQUOT, EFBIG}) {
    std::string message;
    CHECK(failed_with(number, &message) == "TB-STORE-FULL");
    CAPTURE(message);
    CHECK((number == ENOSPC || message.find(std::strerror(number)) != std::string::npos));
  }
}

TEST_CASE("store write failure: a failing disk is not reported as full, and the message has the system's error text") {
  std::string message;
  CHECK(failed_with(EIO, &message) == "TB-STORE-SQL");
  CHECK_THAT(message, Catch::Contains(std::strerror(EIO)));
}

TEST_CASE("store opening: a half-created store is not read, and opening it for writing recovers it") {
  const TemporaryFolder folder;
  const std::string whole = folder.path("whole.db"), half = folder.path("half.db");
  (void)db::RunStore::open(whole);
  Connection writer(whole, Access::kReadWrite);
  REQUIRE(writer.text("PRAGMA journal_mode = DELETE") == "delete");
  writer.execute("PRAGMA cache_size = 1; BEGIN; CREATE TABLE half (a)");
  for (int i = 0; i < 200; ++i) writer.execute("INSERT INTO half VALUES (zeroblob(4000))");
  for (const char* part : {"", "-journal"})
    std::filesystem::copy_file(whole + part, half + part);  // as SIGKILL leaves them
  writer.execute("ROLLBACK");

  CHECK(store_error([&] { (void)RunStore::open_read_only(half); }) == "TB-STORE-OPEN");
  (void)db::RunStore::open(half);
  (void)db::RunStore::open_read_only(half);
  CHECK(Connection(half, Access::kReadOnly).integer("SELECT count(*) FROM sqlite_master WHERE name = 'half'") == 0);
}
