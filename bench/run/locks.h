// Who may run: one run a bench at a time (contract.md, lock file named by the bench's id), and how the next start
// knows that an unended run in a store has no living process.
#pragma once

#include <cstdint>
#include <string>

#include "bench/config.h"
#include "db/run_store.h"
#include "devices/clock.h"

namespace tactbench::bench {

// $XDG_RUNTIME_DIR/tactbench, else in the system's temporary folder; made with mode 0700.
std::string runtime_folder();

// An flock on a file of $XDG_RUNTIME_DIR/tactbench (fallback: the system's temporary folder), released with the
// process however it ends.
class FileLock {
 public:
  FileLock() = default;
  FileLock(const std::string& name, bool exclusive);  // does not wait
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  [[nodiscard]] bool held() const { return fd_ >= 0; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string owner() const;  // text that the holder wrote
  void write_owner(const std::string& text) const;

 private:
  std::string path_;
  int fd_ = -1;
};

// Held by a bench's dead-man as long as it lives, so that the one of a killed run never vents what the next run fills.
// Waits at most `longest` (real time) for it; not held: another dead-man is still at work.
FileLock dead_man_lock(const std::string& bench_id, devices::Nanoseconds longest);

// Waits for a dead-man that still makes the bench safe, at most 15 s. Throws Error TB-BENCH-LOCKED naming pid, run and
// store of who has the bench. A simulated bench lives inside its process and needs no lock.
class BenchLock {
 public:
  explicit BenchLock(const BenchConfig& config);
  void name_run(std::int64_t run, const std::string& db_path) const;  // for whoever is refused

 private:
  FileLock lock_;
};

// Held while a run writes to `db_path`; shared, for several simulated benches may write to one store.
class RunLock {
 public:
  explicit RunLock(const std::string& db_path);

 private:
  FileLock lock_;
};

// Opens the store for a run: FULL durability on hardware, NORMAL under the turned clock; runs left unended by dead
// processes become `interrupted`.
db::RunStore open_for_running(const std::string& db_path, const BenchConfig& config);

}  // namespace tactbench::bench
