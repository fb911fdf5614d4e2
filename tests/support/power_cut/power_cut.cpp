// What a power cut would leave of a store: loaded before the program (LD_PRELOAD), this keeps beside each database file
// and write-ahead log an image of what was synced, in the folder $TACTBENCH_POWER_CUT. Written bytes reach the image
// with the next fsync or fdatasync of that file, not before. With TACTBENCH_DISK_LIES set no sync reaches it. The
// program's own view of its files is not changed. Tests only.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
using Open = int (*)(const char*, int, ...);
using Write = ssize_t (*)(int, const void*, size_t);
using Pwrite = ssize_t (*)(int, const void*, size_t, off64_t);
using Pread = ssize_t (*)(int, void*, size_t, off64_t);
using OfDescriptor = int (*)(int);
using Resize = int (*)(int, off64_t);

struct File {
  std::string image;
  std::vector<std::pair<off64_t, off64_t>> unsynced;  // begin, end
};

struct Disk {
  std::mutex mutex;
  std::map<std::string, File> files;   // by path
  std::map<int, std::string> open_as;  // descriptor -> path
};
Disk& disk() {
  static Disk* one = new Disk;  // outlives whatever still writes at the program's end
  return *one;
}

bool is_watched(std::string_view path) { return path.ends_with(".db") || path.ends_with(".db-wal"); }

void copy(int from, int to, off64_t begin, off64_t end) {
  static const auto read_at = real<Pread>("pread64");
  static const auto write_at = real<Pwrite>("pwrite64");
  char bytes[65536];
  while (begin < end) {
    const auto wanted = static_cast<size_t>(std::min<off64_t>(end - begin, sizeof bytes));
    const ssize_t got = read_at(from, bytes, wanted, begin);
    if (got <= 0 || write_at(to, bytes, static_cast<size_t>(got), begin) != got) return;
    begin += got;
  }
}

int image_descriptor(const File& file) {
  static const auto open_file = real<Open>("open64");
  return open_file(file.image.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
}

int opened(int descriptor, const char* path) {
  const char* folder = std::getenv("TACTBENCH_POWER_CUT");
  if (descriptor < 0 || folder == nullptr || path == nullptr || !is_watched(path)) return descriptor;
  const int error = errno;
  Disk& all = disk();
  const std::scoped_lock lock(all.mutex);
  const std::string name(path);
  all.open_as[descriptor] = name;
  File& file = all.files[name];
  if (file.image.empty()) file.image = std::string(folder) + name.substr(name.find_last_of('/'));
  if (struct stat known{}; stat(file.image.c_str(), &known) != 0) {  // what stands there already is taken as synced
    // Whole or not at all: a kill in the middle is no power cut of the disk.
    struct stat now {};
    const File half{file.image + ".half" + std::to_string(getpid()), {}};
    const int image = image_descriptor(half);
    if (fstat(descriptor, &now) == 0) copy(descriptor, image, 0, now.st_size);
    real<OfDescriptor>("close")(image);
    (void)link(half.image.c_str(), file.image.c_str());  // unless another process has made it meanwhile
    (void)real<int (*)(const char*)>("unlink")(half.image.c_str());
  }
  errno = error;
  return descriptor;
}

void changed(int descriptor, off64_t begin, off64_t end) {
  Disk& all = disk();
  const std::scoped_lock lock(all.mutex);
  if (const auto found = all.open_as.find(descriptor); found != all.open_as.end() && begin < end) {
    all.files[found->second].unsynced.emplace_back(begin, end);
  }
}

void synced(int descriptor) {
  const int error = errno;
  Disk& all = disk();
  const std::scoped_lock lock(all.mutex);
  const auto found = all.open_as.find(descriptor);
  if (found != all.open_as.end() && std::getenv("TACTBENCH_DISK_LIES") == nullptr) {
    File& file = all.files[found->second];
    struct stat now {};
    const int image = image_descriptor(file);
    if (fstat(descriptor, &now) == 0) {
      for (const auto& [begin, end] : file.unsynced)
        copy(descriptor, image, begin, std::min<off64_t>(end, now.st_size));
      (void)real<Resize>("ftruncate64")(image, now.st_size);
    }
    real<OfDescriptor>("close")(image);
    file.unsynced.clear();
  }
  errno = error;
}

}  // namespace

// NOLINTBEGIN(cert-dcl50-cpp): the C library's own declarations
extern "C" {

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  static const auto next = real<Open>("open64");
  return opened(next(path, flags, mode), path);
}
int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  static const auto next = real<Open>("open");
  return opened(next(path, flags, mode), path);
}
int close(int descriptor) {
  {
    Disk& all = disk();
    const std::scoped_lock lock(all.mutex);
    all.open_as.erase(descriptor);
  }
  static const auto next = real<OfDescriptor>("close");
  return next(descriptor);
}
ssize_t write(int descriptor, const void* bytes, size_t count) {
  static const auto next = real<Write>("write");
  const off64_t begin = lseek64(descriptor, 0, SEEK_CUR);
  const ssize_t written = next(descriptor, bytes, count);
  if (begin >= 0 && written > 0) changed(descriptor, begin, begin + written);
  return written;
}
ssize_t pwrite64(int descriptor, const void* bytes, size_t count, off64_t where) {
  static const auto next = real<Pwrite>("pwrite64");
  const ssize_t written = next(descriptor, bytes, count, where);
  if (written > 0) changed(descriptor, where, where + written);
  return written;
}
ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t where) {
  return pwrite64(descriptor, bytes, count, where);
}
int posix_fallocate64(int descriptor, off64_t where, off64_t count) {
  static const auto next = real<int (*)(int, off64_t, off64_t)>("posix_fallocate64");
  const int error = next(descriptor, where, count);
  if (error == 0) changed(descriptor, where, where + count);
  return error;
}
int posix_fallocate(int descriptor, off_t where, off_t count) { return posix_fallocate64(descriptor, where, count); }
int ftruncate64(int descriptor, off64_t size) noexcept {
  static const auto next = real<Resize>("ftruncate64");
  return next(descriptor, size);  // the image takes the length with the next sync
}
int ftruncate(int descriptor, off_t size) noexcept { return ftruncate64(descriptor, size); }
// A journalling file system keeps the order of names: a file that is made anew under a name is not the one that was
// removed, and has nothing of what that one held.
int unlink(const char* path) noexcept {
  static const auto next = real<int (*)(const char*)>("unlink");
  const int result = next(path);
  if (result == 0 && is_watched(path)) {
    Disk& all = disk();
    const std::scoped_lock lock(all.mutex);
    const char* folder = std::getenv("TACTBENCH_POWER_CUT");
    const std::string name(path);
    if (folder != nullptr) (void)next((std::string(folder) + name.substr(name.find_last_of('/'))).c_str());
    all.files.erase(name);
    std::erase_if(all.open_as, [&](const auto& open) { return open.second == name; });
  }
  return result;
}
int fdatasync(int descriptor) {
  static const auto next = real<OfDescriptor>("fdatasync");
  const int result = next(descriptor);
  if (result == 0) synced(descriptor);
  return result;
}
int fsync(int descriptor) {
  static const auto next = real<OfDescriptor>("fsync");
  const int result = next(descriptor);
  if (result == 0) synced(descriptor);
  return result;
}

}  // extern "C"
// NOLINTEND(cert-dcl50-cpp)
