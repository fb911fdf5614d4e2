// Preloaded into a test's PostgreSQL: while the file named by TACTBENCH_FULL_DISK exists, tables cannot grow, as on a
// full disk. Its log goes on, since a server without room for the log ends instead of refusing.
#include <dlfcn.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

bool grows_on_full_disk(int file, std::size_t size, off64_t at) {
  const char* const mark = std::getenv("TACTBENCH_FULL_DISK");
  if (mark == nullptr || access(mark, F_OK) != 0) return false;
  std::array<char, 512> path{};
  const ssize_t length = readlink(("/proc/self/fd/" + std::to_string(file)).c_str(), path.data(), path.size() - 1);
  if (length <= 0 || std::string_view(path.data()).find("/base/") == std::string_view::npos) return false;
  const off64_t now = lseek64(file, 0, SEEK_END);
  return now >= 0 && at + static_cast<off64_t>(size) > now;
}

ssize_t write_at(int file, const void* bytes, std::size_t size, off64_t at) {
  using Write = ssize_t (*)(int, const void*, std::size_t, off64_t);
  static const auto real = reinterpret_cast<Write>(dlsym(RTLD_NEXT, "pwrite64"));
  if (!grows_on_full_disk(file, size, at)) return real(file, bytes, size, at);
  errno = ENOSPC;
  return -1;
}

}  // namespace

extern "C" ssize_t pwrite64(int file, const void* bytes, std::size_t size, off64_t at) {
  return write_at(file, bytes, size, at);
}
extern "C" ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t at) {
  return write_at(file, bytes, size, at);
}
