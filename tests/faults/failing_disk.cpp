#include "tests/faults/failing_disk.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <stdexcept>

namespace tactbench::tests {

namespace {

std::atomic<int> fails_with{0};

bool fails() {
  if (fails_with == 0) return false;
  errno = fails_with;
  return true;
}

ssize_t failing_write(int file, const void* bytes, size_t count) { return fails() ? -1 : ::write(file, bytes, count); }
ssize_t failing_pwrite(int file, const void* bytes, size_t count, off_t where) {
  return fails() ? -1 : ::pwrite(file, bytes, count, where);
}
ssize_t failing_pwrite64(int file, const void* bytes, size_t count, off64_t where) {
  return fails() ? -1 : ::pwrite64(file, bytes, count, where);
}
int failing_fallocate(int file, off_t where, off_t count) {
  return fails() ? fails_with.load() : ::posix_fallocate(file, where, count);
}
int failing_ftruncate(int file, off_t size) { return fails() ? -1 : ::ftruncate(file, size); }

template <class Function>
void replace(const char* name, Function* function) {
  sqlite3_vfs* files = sqlite3_vfs_find(nullptr);
  if (files == nullptr || files->xGetSystemCall(files, name) == nullptr) return;  // not in this build of SQLite
  if (files->xSetSystemCall(files, name, reinterpret_cast<sqlite3_syscall_ptr>(function)) != SQLITE_OK) {
    throw std::runtime_error("SQLite does not let its system calls be replaced");
  }
}

}  // namespace

void disk_fails_with(int error) {
  static const bool replaced = [] {
    replace("write", failing_write);
    replace("pwrite", failing_pwrite);
    replace("pwrite64", failing_pwrite64);
    replace("fallocate", failing_fallocate);
    replace("ftruncate", failing_ftruncate);
    return true;
  }();
  fails_with = replaced ? error : 0;
}

}  // namespace tactbench::tests
