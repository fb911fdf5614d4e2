#include "bench/run/locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>

#include "bench/error.h"
#include "bench/run/recorder.h"
#include "bench/utc.h"

namespace tactbench::bench {

std::string runtime_folder() {
  const char* given = std::getenv("XDG_RUNTIME_DIR");
  std::string base = given != nullptr && *given != '\0'
                         ? std::string(given) + "/tactbench"
                         : (std::filesystem::temp_directory_path() / fmt::format("tactbench-{}", geteuid())).string();
  mkdir(base.c_str(), 0700);
  return base;
}

namespace {

constexpr devices::Nanoseconds kDeadManEnds = std::chrono::seconds(15);

std::string store_lock_name(const std::string& db_path) {
  return "store-" + db::sha256_hex(std::filesystem::weakly_canonical(db_path).string()).substr(0, 16);
}

}  // namespace

FileLock::FileLock(const std::string& name, bool exclusive) : path_(runtime_folder() + "/" + name + ".lock") {
  fd_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd_ < 0) {
    throw Error(ExitCode::kUsage, "TB-LOCK-FILE", "cannot make the lock file", path_,
                "check XDG_RUNTIME_DIR or the folder for temporary files");
  }
  if (flock(fd_, (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB) != 0) {
    close(fd_);
    fd_ = -1;
  }
}

FileLock::~FileLock() {
  if (fd_ >= 0) close(fd_);
}

FileLock::FileLock(FileLock&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}

std::string FileLock::owner() const {
  std::array<char, 200> text{};
  const int fd = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return "unknown";
  const ssize_t size = read(fd, text.data(), text.size() - 1);
  close(fd);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "unknown";
}

void FileLock::write_owner(const std::string& text) const {
  if (ftruncate(fd_, 0) != 0 || pwrite(fd_, text.data(), text.size(), 0) < 0) return;  // the lock itself holds
}

FileLock dead_man_lock(const std::string& bench_id, devices::Nanoseconds longest) {
  constexpr auto kTurn = std::chrono::milliseconds(10);
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    FileLock lock(bench_id + ".dead-man", true);
    if (lock.held() || std::chrono::steady_clock::now() >= end) return lock;
    std::this_thread::sleep_for(kTurn);
  }
}

BenchLock::BenchLock(const BenchConfig& config) : lock_(!config.in_process ? FileLock(config.id, true) : FileLock()) {
  if (config.in_process) return;
  if (!lock_.held()) {
    throw Error(ExitCode::kUsage, "TB-BENCH-LOCKED",
                fmt::format("bench '{}' is in use by {}", config.id, lock_.owner()), lock_.path(),
                "wait for it to end, or end it: tactbench stop");
  }
  lock_.write_owner(fmt::format("pid {}", getpid()));
  const FileLock dead_man = dead_man_lock(config.id, kDeadManEnds);
  if (dead_man.held()) return;
  throw Error(
      ExitCode::kUsage, "TB-BENCH-LOCKED",
      fmt::format("the dead-man ({}) of the run before is still making bench '{}' safe", dead_man.owner(), config.id),
      dead_man.path(), "look at the rig: the chamber may hold pressure; then try again");
}

void BenchLock::name_run(std::int64_t run, const std::string& db_path) const {
  if (lock_.held()) lock_.write_owner(fmt::format("pid {}, run {} of {}", getpid(), run, db_path));
}

RunLock::RunLock(const std::string& db_path) : lock_(store_lock_name(db_path), false) {}

db::RunStore open_for_running(const std::string& db_path, const BenchConfig& config) {
  const bool hardware = !config.in_process;
  db::RunStore store = db::RunStore::open(db_path, hardware ? db::Durability::kFull : db::Durability::kNormal);
  const FileLock alone(store_lock_name(db_path), true);  // nobody is writing a run to this store
  if (alone.held()) (void)store.mark_interrupted(utc_now());
  return store;
}

}  // namespace tactbench::bench
