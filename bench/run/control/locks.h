// Names and locks of this machine. One run per bench at a time, and one process per run of a store: the next start uses
// them to find unended runs of a store that have no living process. And which user is behind a local socket.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "db/run_store.h"
#include "devices/clock.h"

namespace tactbench::bench {

// Names that only one process at a time can hold on this machine, for all users and logins: abstract sockets of the
// kernel. Such a name needs no folder and no file, so no user can remove, replace or link it, and it disappears with
// its process. Any user can take a free name and so block a bench; the error then names that user. One network
// namespace is one machine: a container needs the host's (docker run --network host). TACTBENCH_RUNTIME_DIR names a
// folder of this user, closed to all others; programs with this setting use separate names: for tests and parallel
// simulated rigs, never for a real rig.
class MachineName {
 public:
  MachineName() = default;
  // Takes a name such as "BENCH" or "BENCH/dead-man", if it is free, and listens there for connections. Throws Error
  // TB-BENCH-NAME if the system refuses, TB-FOLDER-UNSAFE for TACTBENCH_RUNTIME_DIR.
  explicit MachineName(const std::string& what);
  ~MachineName();
  MachineName(MachineName&& other) noexcept;
  MachineName& operator=(MachineName&&) = delete;
  [[nodiscard]] bool held() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // of the listening socket; it does not block
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] std::string owner() const;  // the holder: "alice (pid 812)"

 private:
  std::string text_;
  int descriptor_ = -1;
};

// All names held within this scope, sorted, without their common prefix: "BENCH", "BENCH/dead-man".
std::vector<std::string> held_names();
// The name as the system lists it: "@tactbench/BENCH".
std::string shown_name(const std::string& what);

// A socket that connects to `what` without waiting, -1 and errno: ECONNREFUSED the name is free, EAGAIN the queue of
// its holder is full.
int connect_to_name(const std::string& what);

// The process at the other end of a local socket, as reported by the kernel. A run may be commanded by root, the run's
// own user, and members of the group `tactbench`. An answer in the name of a run is believed if it comes from one of
// these users. Root also believes a process of another user if that process holds the lock of the run that it names.
inline constexpr const char* kGroupName = "tactbench";

// The group's number; none: the machine has no such group.
std::optional<gid_t> commanding_group();

struct Peer {
  pid_t process = 0;
  uid_t user = 0;
  bool in_group = false;
};

// The peer of a connected socket: the client at the time it connected, or the server at the time it began to listen.
// None: not known.
std::optional<Peer> peer_of(int descriptor, std::optional<gid_t> group = commanding_group());

// Whether a process of user `own` may accept commands from the peer, or trust its answers.
bool is_trusted(const Peer& peer, uid_t own);

// "alice (pid 812)"; "user 1003 (pid 812)" if /etc/passwd does not have the user: name servers may be slow and are not
// queried.
std::string peer_text(const Peer& peer);

// Name held by a bench's dead-man as long as it lives, so that the dead-man of a killed run never vents the chamber of
// the next run. Waits at most `longest` (real time) for it; if it is not held, another dead-man is still active.
MachineName dead_man_name(const std::string& bench_id, devices::Nanoseconds longest);

// Holds the bench for this process until the object is destroyed; its run answers commands on the same name. Waits at
// most 15 s for a dead-man that is still making the bench safe. Throws Error TB-BENCH-LOCKED with the process, run and
// store that hold the bench. A bench simulated inside this process is not shared and needs no lock.
class BenchLock {
 public:
  explicit BenchLock(const BenchConfig& config);
  [[nodiscard]] const MachineName* name() const { return name_.held() ? &name_ : nullptr; }

 private:
  MachineName name_;
};

// Locks on the file STORE-lock next to the store, one byte each: every process that can open the store sees them, and
// they end with their process. Locks on the store itself would release SQLite's locks when that file is closed. The
// lock file is empty, has the store's mode and owner, and is not removed.
class StoreLocks {
 public:
  explicit StoreLocks(const std::string& db_path);  // takes no lock. Throws Error TB-STORE-LOCK
  ~StoreLocks();
  StoreLocks(const StoreLocks&) = delete;
  StoreLocks& operator=(const StoreLocks&) = delete;
  // True when no process writes a run to this store; no run can begin while this lock is held. Does not wait.
  [[nodiscard]] bool try_lock_store() const { return take(kWhole, true); }
  // Lock held while a run writes to the store; shared by several runs. Waits while another start searches for dead
  // runs; throws Error TB-STORE-LOCK if that takes longer than `longest`.
  void share(std::chrono::milliseconds longest) const;
  // Locks the run for this process. Throws Error TB-RUN-LIVE when another process still holds it after `longest`.
  void take_run(std::int64_t run, std::chrono::milliseconds longest) const;
  // Recreates the lock file if it was removed or replaced: people delete it because it is empty. True: a new one was
  // made and holds the same locks. Throws as share() and take_run() if another process was faster.
  bool renew(std::int64_t run);

 private:
  static constexpr std::int64_t kWhole = 0;  // the byte of a run is at its number
  [[nodiscard]] bool take(std::int64_t byte, bool exclusive) const;
  [[nodiscard]] bool take_within(std::int64_t byte, bool exclusive, std::chrono::milliseconds longest) const;
  std::string path_;
  int file_ = -1;
};

// Held for a whole run: shares the store before the run's row is made or reopened, then locks the run itself.
class RunLock {
 public:
  explicit RunLock(const std::string& db_path);  // Throws Error TB-STORE-LOCK
  void lock_new_run(std::int64_t run) const;     // a run whose row was just made
  // For a run to be resumed. Throws Error TB-RUN-LIVE immediately if another process carries it out.
  void lock_for_resume(std::int64_t run) const;
  bool renew(std::int64_t run) { return locks_.renew(run); }

 private:
  StoreLocks locks_;
};

// Whether a process carries out that run of the store now; takes no lock. None: no readable lock file.
std::optional<bool> is_carried_out(const std::string& db_path, std::int64_t run);
// Whether that process carries out a run of the store: according to the kernel it holds a lock that only a process with
// write access to the store can take. Also false if the kernel does not show its locks; root can see those of any
// process.
bool carries_out_run_of(const Peer& process, const std::string& db_path);

// Opens the store for a run: FULL durability on hardware, NORMAL under the manual clock. If no process writes a run to
// this store, unended runs of dead processes become `interrupted`.
db::RunStore open_for_running(const std::string& db_path, const BenchConfig& config);

}  // namespace tactbench::bench
