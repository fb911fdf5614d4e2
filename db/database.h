// What the parts of a RunStore share: its connection, the statements used at every frame, and the chain of each open
// run.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "db/hash_chain.h"
#include "db/schema.h"
#include "db/sqlite.h"

namespace tactbench::db {

// Kinds of rows stored in addition to a run's content. Each has a row in seals, renewed with every change: the number
// of its rows, and their SHA-256.
inline constexpr std::array kSealed = {"fits", "verdicts", "approvals", "void"};
struct Seal {
  std::int64_t count = 0;
  std::string sha256;
};

// The keys of a run's frames lie between these two.
constexpr std::int64_t frames_above(std::int64_t run) { return run * kFramesPerRun; }
constexpr std::int64_t frames_below(std::int64_t run) { return (run + 1) * kFramesPerRun; }

class Database {
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

  void require_run(std::int64_t run);   // TB-STORE-NOT-FOUND, naming the existing ones
  OpenRun& open_run(std::int64_t run);  // TB-STORE-NOT-FOUND, TB-STORE-CONFLICT when it has ended
  // To be called within a transaction, because another process may have ended the run meanwhile. TB-STORE-CONFLICT.
  void require_open(std::int64_t run);
  const BranchRecord& branch_of(std::int64_t run, std::int64_t branch);
  // A growing log costs a commit of the file system's journal at each commit of the store; an overwritten log does not.
  // So with durable commits the log is extended once to the length at which SQLite restarts it (1000 pages).
  void preallocate_log();
  Seal seal_now(std::int64_t run, const std::string& kind);  // of what is there
  void seal(std::int64_t run, const std::string& kind);      // stores it; part of the caller's transaction

  std::string path;
  sqlite::Connection connection;
  HashChain hasher;
  std::map<std::int64_t, OpenRun> open_runs;
  BranchRecord last_branch;  // branch of the last frame, and its run
  std::int64_t last_branch_run = 0;
  // Prepared once; the one that stores a frame is a transaction by itself.
  std::unique_ptr<sqlite::Statement> frame_statement, time_statement;
};

}  // namespace tactbench::db
