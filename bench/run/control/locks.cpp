#include "bench/run/control/locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/common/utc.h"
#include "bench/run/control/control_client.h"

namespace tactbench::bench {

namespace {

constexpr devices::Nanoseconds kDeadManEnds = std::chrono::seconds(15);

// Who holds it, and with which run; a stopped process does not answer.
std::string holder_of(const MachineName& name) {
  const std::optional<LiveRun> live = send_command(name.text(), Command::kStatus);
  if (!live || live->denied) return name.owner();
  return fmt::format("{}, run {} of {}", peer_text(live->server), live->status.run, live->status.store);
}

[[noreturn]] void refuse_bench(const std::string& what, const MachineName& name, const std::string& remedy) {
  throw Error("TB-BENCH-LOCKED", what, shown_name(name.text()), remedy);
}

}  // namespace

MachineName dead_man_name(const std::string& bench_id, devices::Nanoseconds longest) {
  constexpr auto kTurn = std::chrono::milliseconds(10);
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    MachineName name(file_name(bench_id) + "/dead-man");
    if (name.held() || std::chrono::steady_clock::now() >= end) return name;
    std::this_thread::sleep_for(kTurn);
  }
}

BenchLock::BenchLock(const BenchConfig& config)
    : name_(config.in_process ? MachineName() : MachineName(file_name(config.id))) {
  if (config.in_process) return;
  if (!name_.held())
    refuse_bench(fmt::format("bench '{}' is in use by {}", config.id, holder_of(name_)), name_,
                 "wait for it to end, or end it: tactbench stop --bench " + config.id);
  const MachineName dead_man = dead_man_name(config.id, kDeadManEnds);
  if (dead_man.held()) return;
  refuse_bench(
      fmt::format("the dead-man ({}) of the previous run is still making bench '{}' safe", dead_man.owner(), config.id),
      dead_man, "inspect the rig: the chamber may hold pressure; then try again");
}

namespace {

constexpr const char* kEnding = "-lock";
constexpr std::chrono::milliseconds kLockTurn{5};
constexpr std::chrono::seconds kOtherStart{15};  // longer than a busy store delays it

std::string lock_path(const std::string& db_path) {
  return std::filesystem::weakly_canonical(db_path).string() + kEnding;
}

// As SQLite does for its own files next to the store: the same users may write them.
int make_lock_file(const std::string& path, const std::string& db_path) {
  struct stat store {};
  if (::stat(db_path.c_str(), &store) != 0) return -1;
  const mode_t mode = store.st_mode & 0666;
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
  if (file < 0) return -1;
  (void)!::fchmod(file, mode);  // whatever the umask left
  if (::geteuid() == 0) (void)!::fchown(file, store.st_uid, store.st_gid);
  return file;
}

int open_lock_file(const std::string& path, const std::string& db_path) {
  for (int turn = 0; turn < 2; ++turn) {
    const int file = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    if (file >= 0 || errno != ENOENT) return file;
    const int made = make_lock_file(path, db_path);
    if (made >= 0 || errno != EEXIST) return made;
  }
  return -1;
}

}  // namespace

StoreLocks::StoreLocks(const std::string& db_path) : path_(lock_path(db_path)), file_(open_lock_file(path_, db_path)) {
  struct stat found {};
  if (file_ >= 0 && ::fstat(file_, &found) == 0 && S_ISREG(found.st_mode)) return;
  const std::string why = file_ >= 0 ? "it is not a file" : std::strerror(errno);
  if (file_ >= 0) ::close(file_);
  throw Error("TB-STORE-LOCK", "the store's lock file cannot be used: " + why, path_);
}

StoreLocks::~StoreLocks() { ::close(file_); }

bool StoreLocks::take(std::int64_t byte, bool exclusive) const {
  struct flock wanted {};
  wanted.l_type = static_cast<short>(exclusive ? F_WRLCK : F_RDLCK);
  wanted.l_whence = SEEK_SET;
  wanted.l_start = byte;
  wanted.l_len = 1;
  if (::fcntl(file_, F_OFD_SETLK, &wanted) == 0) return true;
  if (errno == EAGAIN || errno == EACCES) return false;
  throw Error("TB-STORE-LOCK", fmt::format("the store cannot be locked: {}", std::strerror(errno)), path_,
              "keep the store on a local disk");
}

bool StoreLocks::take_within(std::int64_t byte, bool exclusive, std::chrono::milliseconds longest) const {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!take(byte, exclusive)) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(kLockTurn);
  }
  return true;
}

void StoreLocks::share(std::chrono::milliseconds longest) const {
  if (take_within(kWhole, false, longest)) return;
  throw Error("TB-STORE-LOCK",
              fmt::format("another start has held the store for {:g} s", static_cast<double>(longest.count()) / 1000.0),
              path_, "find the process that has the store open, and try again");
}

void StoreLocks::take_run(std::int64_t run, std::chrono::milliseconds longest) const {
  if (take_within(run, true, longest)) return;
  throw Error("TB-RUN-LIVE", fmt::format("another process carries out run {} of this store", run), path_,
              "wait for it to end, or end it: tactbench stop " + std::to_string(run));
}

bool StoreLocks::renew(std::int64_t run) {
  struct stat open {
  }, there{};
  if (::fstat(file_, &open) == 0 && ::lstat(path_.c_str(), &there) == 0 && open.st_ino == there.st_ino &&
      open.st_dev == there.st_dev)
    return false;
  StoreLocks again(path_.substr(0, path_.size() - std::strlen(kEnding)));
  again.share({});
  again.take_run(run, {});
  std::swap(file_, again.file_);
  return true;
}

RunLock::RunLock(const std::string& db_path) : locks_(db_path) { locks_.share(kOtherStart); }

// Another process that tries to resume this number holds its lock for a moment.
void RunLock::lock_new_run(std::int64_t run) const { locks_.take_run(run, kOtherStart); }

void RunLock::lock_for_resume(std::int64_t run) const { locks_.take_run(run, std::chrono::milliseconds(0)); }

std::optional<bool> is_carried_out(const std::string& db_path, std::int64_t run) {
  const int file = ::open(lock_path(db_path).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return std::nullopt;
  struct flock asked {};
  asked.l_type = F_RDLCK;
  asked.l_whence = SEEK_SET;
  asked.l_start = run;
  asked.l_len = 1;
  const bool told = ::fcntl(file, F_OFD_GETLK, &asked) == 0;
  ::close(file);
  return told ? std::optional(asked.l_type != F_UNLCK) : std::nullopt;
}

bool carries_out_run_of(const Peer& process, const std::string& db_path) {
  constexpr int kMost = 256;  // descriptors examined: a run opens this one early, and a foreign process may have many
  const std::filesystem::path folder = fmt::format("/proc/{}", process.process);
  struct stat lock {
  }, found{};
  if (::stat(lock_path(db_path).c_str(), &lock) != 0) return false;
  // The number may be another process's by now.
  if (::stat(folder.c_str(), &found) != 0 || found.st_uid != process.user) return false;
  std::error_code failed;
  std::filesystem::directory_iterator file(folder / "fd", failed);
  for (int i = 0; !failed && i < kMost && file != std::filesystem::directory_iterator(); ++i, file.increment(failed)) {
    if (::stat(file->path().c_str(), &found) != 0 || found.st_dev != lock.st_dev || found.st_ino != lock.st_ino)
      continue;
    std::ifstream told(folder / "fdinfo" /
                       file->path().filename());  // "lock: 1: OFDLCK ADVISORY  WRITE -1 fe:00:812 7 7"
    for (std::string line; std::getline(told, line);)
      if (line.starts_with("lock:") && line.find(" WRITE ") != std::string::npos) return true;
  }
  return false;
}

db::RunStore open_for_running(const std::string& db_path, const BenchConfig& config) {
  const bool hardware = !config.in_process;
  db::RunStore store = db::RunStore::open(db_path, hardware ? db::Durability::kFull : db::Durability::kNormal);
  // A run makes or opens its row only while it shares the store (RunLock): under the exclusive lock no unended run is
  // alive, and none begins.
  const StoreLocks locks(db_path);
  if (locks.try_lock_store()) (void)store.mark_interrupted(utc_now());
  return store;
}

}  // namespace tactbench::bench
