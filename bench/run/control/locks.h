// Locks of a run: one run per bench at a time on this machine, and one process per run of a store. The next start uses
// them to find unended runs of a store that have no living process.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "bench/config/config.h"
#include "bench/run/control/machine_name.h"
#include "bench/run/control/peer.h"
#include "db/run_store.h"
#include "devices/clock.h"

namespace tactbench::bench {

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
