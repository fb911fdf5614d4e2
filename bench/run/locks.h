// Who may run: one run a bench at a time (contract.md, lock file named by the bench's id), and how the next start
// knows that an unended run in a store has no living process.
#pragma once

#include <string>

#include "bench/config.h"
#include "db/run_store.h"

namespace tactbench::bench {

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

// Throws Error TB-BENCH-LOCKED naming pid and store of the run that has the bench. A simulated bench lives inside its
// process and needs no lock.
class BenchLock {
 public:
  explicit BenchLock(const BenchConfig& config);

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
