// Who may run: one run a bench at a time on this machine, and one process a run of a store; how the next start knows
// that an unended run in a store has no living process.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "bench/config/config.h"
#include "bench/run/control/machine_name.h"
#include "db/run_store.h"
#include "devices/clock.h"

namespace tactbench::bench {

// Held by a bench's dead-man as long as it lives, so that the one of a killed run never vents what the next run fills.
// Waits at most `longest` (real time) for it; not held: another dead-man is still at work.
MachineName dead_man_name(const std::string& bench_id, devices::Nanoseconds longest);

// The bench is this process's until the object goes; its run answers words on the same name. Waits for a dead-man that
// still makes the bench safe, at most 15 s. Throws Error TB-BENCH-LOCKED naming process, run and store of who has the
// bench. A bench simulated inside this process is shared with nobody and needs no lock.
class BenchLock {
 public:
  explicit BenchLock(const BenchConfig& config);
  [[nodiscard]] const MachineName* name() const { return name_.held() ? &name_ : nullptr; }

 private:
  MachineName name_;
};

// Locks on the file STORE-lock beside the store, one byte each: whoever reaches the store meets them, and they go with
// the process however it ends. Locks on the store itself would take those of SQLite with them when it is closed. The
// file is empty, made with the store's own mode and owner, and stays.
class StoreLocks {
 public:
  explicit StoreLocks(const std::string& db_path);  // takes none. Throws Error TB-STORE-LOCK
  ~StoreLocks();
  StoreLocks(const StoreLocks&) = delete;
  StoreLocks& operator=(const StoreLocks&) = delete;
  // Nobody writes a run to this store, and nobody begins while this is held. Does not wait.
  [[nodiscard]] bool take_whole() const { return take(kWhole, true); }
  // Held while a run writes to the store; several may. Waits for a start that looks for dead runs; throws Error
  // TB-STORE-LOCK when that takes longer than `longest`.
  void share(std::chrono::milliseconds longest) const;
  // The run is this process's alone. Throws Error TB-RUN-LIVE when it is another's, after `longest`.
  void take_run(std::int64_t run, std::chrono::milliseconds longest) const;

 private:
  static constexpr std::int64_t kWhole = 0;  // a run's byte is at its number
  [[nodiscard]] bool take(std::int64_t byte, bool exclusive) const;
  [[nodiscard]] bool take_within(std::int64_t byte, bool exclusive, std::chrono::milliseconds longest) const;
  std::string path_;
  int file_ = -1;
};

// For a run's whole life: the store shared, before its row is made or opened again, and then the run itself.
class RunLock {
 public:
  explicit RunLock(const std::string& db_path);  // Throws Error TB-STORE-LOCK
  void take_new(std::int64_t run) const;         // whose row was just made
  // One to be gone on with. Throws Error TB-RUN-LIVE at once when another process does so.
  void take_again(std::int64_t run) const;

 private:
  StoreLocks locks_;
};

// Whether a process carries out that run of the store now, told without taking a lock. None: there is no lock file that
// could be read.
std::optional<bool> is_carried_out(const std::string& db_path, std::int64_t run);

// Opens the store for a run: FULL durability on hardware, NORMAL under the turned clock; runs left unended by dead
// processes become `interrupted`, if nobody writes a run to this store.
db::RunStore open_for_running(const std::string& db_path, const BenchConfig& config);

}  // namespace tactbench::bench
