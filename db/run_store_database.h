// Internals of a RunStore: its connection, the statements used at every frame, and the chain of each open run.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "db/hash_chain.h"
#include "db/run_store.h"
#include "db/schema.h"
#include "db/sqlite.h"

namespace tactbench::db {

// Kinds of rows stored in addition to a run's content, each kind with its own hash (seals.cpp).
inline constexpr std::array kSealed = {"fits", "verdicts", "approvals", "void"};

// The keys of a run's frames are above `first` and below `end`.
constexpr std::int64_t frames_above(std::int64_t run) { return run * kFramesPerRun; }
constexpr std::int64_t frames_below(std::int64_t run) { return (run + 1) * kFramesPerRun; }

class RunStore::Database {
 public:
  Database(const std::string& given_path, const std::string& absolute_path, sqlite::Access access)
      : path(given_path), connection(absolute_path, access) {
    connection.disable_triggers_and_views();
  }

  // A run that accepts rows. The chain is empty until the first frame; devices may be set until then.
  struct OpenRun {
    std::int64_t frames = 0;
    std::optional<Digest> chain;
  };

  OpenRun& open_run(std::int64_t run);  // TB-STORE-NOT-FOUND, TB-STORE-CONFLICT when it has ended
  // To be called within a transaction, because another process may have ended the run meanwhile. TB-STORE-CONFLICT.
  void require_open(std::int64_t run);
  const BranchRecord& branch_of(std::int64_t run, std::int64_t branch);
  void require_run(std::int64_t run);     // TB-STORE-NOT-FOUND, naming the existing ones
  void require_frames(std::int64_t run);  // the same, and TB-STORE-PRUNED
  Digest header_digest(std::int64_t run);
  // A growing log costs a commit of the file system's journal at each commit of the store; an overwritten log does not.
  // So with durable commits the log is extended once to the length at which SQLite restarts it (1000 pages).
  void preallocate_log();
  void insert_devices(std::int64_t run, const std::vector<DeviceRecord>& devices);
  void insert_event(std::int64_t run, const EventRecord& event);
  std::int64_t insert_baseline(const BaselineRecord& baseline, const std::set<std::int64_t>& runs);
  // The last update of the run's row. Part of the caller's transaction.
  void close_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe, const std::string& utc);

  RunRecord run(std::int64_t number);
  std::vector<BranchRecord> branches(std::int64_t run);
  std::vector<EventRecord> events(std::int64_t run);
  std::vector<CheckRecord> checks(std::int64_t run);
  std::vector<SeriesRecord> series(std::int64_t run);
  RunEnd end_of(std::int64_t run);  // of an open run, without outcome, reason and safe state
  RunEnd end_of(const RunRecord& run);
  template <class Take>
  void for_each_frame(std::int64_t run, Take take);

  std::string path;
  sqlite::Connection connection;
  HashChain hasher;
  std::map<std::int64_t, OpenRun> open_runs;
  BranchRecord last_branch;  // branch of the last frame, and its run
  std::int64_t last_branch_run = 0;
  std::unique_ptr<sqlite::Statement> frame_statement, time_statement;
};

template <class Take>
void RunStore::Database::for_each_frame(std::int64_t run, Take take) {
  sqlite::Statement rows(connection,
                         fmt::format("SELECT {}, {} FROM frames WHERE frame > ? AND frame < ? ORDER BY frame",
                                     FrameRecord::kColumns, WrenchRecord::kColumns));
  rows.bind(frames_above(run), frames_below(run));
  FrameRecord f;
  while (rows.step()) {
    double target_n = 0.0;
    rows.read(f.row(), target_n);
    if (std::isnan(target_n)) {
      f.wrench.reset();
    } else {
      WrenchRecord& w = f.wrench.emplace();
      w.target_n = target_n;
      rows.read_from(std::tuple_size_v<decltype(f.row())> + 1, w.force_start_n, w.wrench, w.raw, w.place_mm);
    }
    take(f);
  }
}

}  // namespace tactbench::db
