#include "bench/run/control/locks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/common/utc.h"
#include "bench/run/control/control_client.h"
#include "db/run_store.h"

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
  const bool known = ::fcntl(file, F_OFD_GETLK, &asked) == 0;
  ::close(file);
  return known ? std::optional(asked.l_type != F_UNLCK) : std::nullopt;
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
    std::ifstream fdinfo(folder / "fdinfo" /
                         file->path().filename());  // "lock: 1: OFDLCK ADVISORY  WRITE -1 fe:00:812 7 7"
    for (std::string line; std::getline(fdinfo, line);)
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

namespace {

constexpr int kMostWaiting = 64;  // connections that may wait to be taken

std::string scope_prefix() {
  const char* folder = std::getenv("TACTBENCH_RUNTIME_DIR");
  if (folder == nullptr || *folder == '\0') return "tactbench/";
  check_private_folder(folder);
  const std::string path = std::filesystem::canonical(folder).string();
  return "tactbench:" + db::sha256_hex(path).substr(0, 16) + "/";
}

struct AbstractAddress {
  sockaddr_un address{};
  socklen_t size = 0;
  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address); }
};

AbstractAddress abstract_address(const std::string& text) {
  AbstractAddress made;
  made.address.sun_family = AF_UNIX;  // sun_path[0] stays 0: abstract
  if (text.size() >= sizeof(made.address.sun_path)) {
    throw Error("TB-BENCH-NAME", "the name is too long for the system", text);
  }
  std::memcpy(made.address.sun_path + 1, text.data(), text.size());
  made.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return made;
}

int new_socket() { return ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

}  // namespace

MachineName::MachineName(const std::string& what) : text_(what) {
  const AbstractAddress wanted = abstract_address(scope_prefix() + what);
  descriptor_ = new_socket();
  const bool bound = descriptor_ >= 0 && ::bind(descriptor_, wanted.get(), wanted.size) == 0;
  if (bound && ::listen(descriptor_, kMostWaiting) == 0) return;
  const int why = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (why == EADDRINUSE) return;
  throw Error("TB-BENCH-NAME", fmt::format("the system refuses a socket: {}", std::strerror(why)), shown_name(what),
              "check the limits of open files (ulimit -n) and memory");
}

MachineName::~MachineName() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

MachineName::MachineName(MachineName&& other) noexcept
    : text_(std::move(other.text_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

std::string MachineName::owner() const {
  const int descriptor = connect_to_name(text_);
  if (descriptor < 0) return errno == ECONNREFUSED ? "a process that has just ended" : "a process that does not answer";
  const std::optional<Peer> peer = peer_of(descriptor);
  ::close(descriptor);
  return peer ? peer_text(*peer) : "unknown";
}

std::vector<std::string> held_names() {
  const std::string prefix = fmt::format("@{}", scope_prefix());
  std::vector<std::string> names;
  std::ifstream table("/proc/net/unix");  // "slot: RefCount Protocol Flags Type St Inode Path"
  for (std::string line; std::getline(table, line);) {
    std::istringstream text(line);
    std::string slot, references, protocol, flags, type, state, inode, path;
    if (!(text >> slot >> references >> protocol >> flags >> type >> state >> inode >> path)) continue;
    const bool listens = flags == "00010000";  // not the accepted ones, which have the name, too
    if (listens && path.starts_with(prefix)) names.push_back(path.substr(prefix.size()));
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string shown_name(const std::string& what) { return fmt::format("@{}{}", scope_prefix(), what); }

int connect_to_name(const std::string& what) {
  const AbstractAddress wanted = abstract_address(scope_prefix() + what);
  const int descriptor = new_socket();
  if (descriptor < 0) return -1;
  if (::connect(descriptor, wanted.get(), wanted.size) == 0) return descriptor;
  const int why = errno;
  ::close(descriptor);
  errno = why;
  return -1;
}

namespace {
constexpr std::size_t kEntry = 1 << 16;  // bytes of a line of a database
}

std::optional<gid_t> commanding_group() {
  std::vector<char> text(kEntry);
  group entry{};
  group* found = nullptr;
  if (::getgrnam_r(kGroupName, &entry, text.data(), text.size(), &found) != 0 || found == nullptr) return std::nullopt;
  return found->gr_gid;
}

std::optional<Peer> peer_of(int descriptor, std::optional<gid_t> group) {
  ucred credentials{};
  socklen_t size = sizeof(credentials);
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0 || credentials.pid < 0)
    return std::nullopt;
  Peer peer{credentials.pid, credentials.uid, group && credentials.gid == *group};
  if (!group || peer.in_group) return peer;
  // The groups of the process itself, not those of its user in the user database: the process may have dropped them, or
  // may have logged in before it was added.
  std::vector<gid_t> groups(64);
  for (int turn = 0; turn < 2; ++turn) {
    size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
    const bool got_all = ::getsockopt(descriptor, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) == 0;
    groups.resize(size / sizeof(gid_t));
    if (!got_all) continue;  // too many: `size` holds their number
    peer.in_group = std::find(groups.begin(), groups.end(), *group) != groups.end();
    break;
  }
  return peer;
}

bool is_trusted(const Peer& peer, uid_t own) { return peer.user == 0 || peer.user == own || peer.in_group; }

std::string peer_text(const Peer& peer) {
  std::string name = fmt::format("user {}", peer.user);
  std::vector<char> text(kEntry);
  if (const std::unique_ptr<FILE, int (*)(FILE*)> users(std::fopen("/etc/passwd", "re"), std::fclose); users) {
    passwd entry{};
    passwd* found = nullptr;
    while (::fgetpwent_r(users.get(), &entry, text.data(), text.size(), &found) == 0) {
      if (entry.pw_uid != peer.user) continue;
      name = entry.pw_name;
      break;
    }
  }
  return fmt::format("{} (pid {})", name, peer.process);
}

}  // namespace tactbench::bench
