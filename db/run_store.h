// The store of a bench, one SQLite file (WAL): runs, frames, events, models, verdicts. Each frame is one committed
// transaction, so a process that dies loses no acknowledged data. Not thread-safe: one owner; other processes may read.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "db/models.h"
#include "db/remarks.h"
#include "db/run_writer.h"
#include "db/store_error.h"

namespace tactbench::db {

enum class Durability {
  kFull,    // synchronous=FULL: survives a power failure; for hardware
  kNormal,  // survives the death of the process; for simulations with a manual clock
};

inline constexpr int kSchemaVersion = 1;

// The file with all its parts. Here: what concerns more than one run.
class RunStore : public RunWriter, public Models, public Remarks {
 public:
  // Opens or creates `path`; refuses the store of a build with another schema (TB-STORE-OTHER-SCHEMA), a file that is
  // not a store, further tables, indexes, views or triggers in a store (TB-STORE-FOREIGN), and network file systems. An
  // older schema is migrated to kSchemaVersion after a backup has been made next to it (store_file.h).
  static RunStore open(const std::string& path, Durability durability = Durability::kFull);
  // Opens an existing file without ever writing to it. TB-STORE-OPEN when it does not exist. A store on a network file
  // system is read as it is, with a warning (store_file.h); TB-STORE-NETWORK when it has a write-ahead log.
  static RunStore open_read_only(const std::string& path);
  RunStore(RunStore&&) noexcept;
  RunStore& operator=(RunStore&&) noexcept;
  ~RunStore();

  // Copies the present state of the store into a new file, even while another process writes a run. TB-STORE-EXISTS
  // when the file exists already; a copy that fails leaves no file.
  void snapshot(const std::string& path) const;
  // Copies ended runs of another store with their sensors, fits and verdicts; returns their numbers here. Copies all or
  // none: TB-STORE-EXISTS if one is here already (same UUID), TB-STORE-CONFLICT if one has changed since it was stored,
  // has not ended, or its sensor is registered differently here. Models, verdicts and approvals must also be unchanged.
  // Verdicts are copied with the judged run; without it they are left out, even if the run of the models is copied.
  std::vector<std::int64_t> copy_runs_from(const RunReader& other, const std::vector<std::int64_t>& runs);
  // The next run gets this number, or the next free one above it: for copies of runs from several stores.
  void number_next_run(std::int64_t number);

  // Nights. add_night: TB-STORE-CONFLICT when a result names a run that is not there.
  std::int64_t add_night(const NightRecord& night);
  [[nodiscard]] std::vector<NightRecord> nights() const;  // oldest first

  // Removal of frames by a retention rule; all other data of the run stay. Empty: the frames may be removed; else why
  // not: not simulated, not of a night, not ended, void, pinned (tag), in an approved report, used by the models of
  // such a run, no frames.
  [[nodiscard]] std::string why_not_pruned(std::int64_t run) const;
  // One transaction. TB-STORE-CONFLICT if they may not be removed, or if the run has changed since it was stored.
  PrunedRecord prune_frames(std::int64_t run, const std::string& rule, const std::string& utc);
  void shrink();  // returns the file's free pages to the file system; needs as much free space as the store, and
                  // exclusive use of it

  // TB-STORE-GONE when the file was removed, moved, replaced or cut off; data that is written still goes into the open
  // file.
  void require_in_place() const;
  // Saves a complete copy of the open store, whose file was moved or removed, next to its old path (or in the system's
  // temporary folder) and returns the name. Removes the log at the old path, which would damage the next store there.
  // Throws TB-STORE-GONE if the open store is no longer complete.
  [[nodiscard]] std::string rescue() const;

 private:
  explicit RunStore(std::unique_ptr<Database> database);
  std::unique_ptr<Database> database_;
};

// SHA-256 of `text` as 64 hex digits.
std::string sha256_hex(const std::string& text);
// Random UUID, version 4 (RFC 9562).
std::string new_uuid();

// Versions of the shared libraries that db/ uses to store and to hash.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::db
