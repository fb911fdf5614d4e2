// A file that cannot be written, by the operating system's own number for why: SQLite is given a write that fails.
#include <sqlite3.h>
#include <sys/types.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::sqlite::Access;
using db::sqlite::Connection;

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

TEST_CASE("a full disk, a full quota and a file size limit are all reported as a full store") {
  for (const int number : {ENOSPC, EDQUOT, EFBIG}) {
    std::string message;
    CHECK(failed_with(number, &message) == "TB-STORE-FULL");
    CAPTURE(message);
    CHECK((number == ENOSPC || message.find(std::strerror(number)) != std::string::npos));
  }
}

TEST_CASE("a failing disk is not reported as full, and its error number is given in words") {
  std::string message;
  CHECK(failed_with(EIO, &message) == "TB-STORE-SQL");
  CHECK_THAT(message, Catch::Contains(std::strerror(EIO)));
}
