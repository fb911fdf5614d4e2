// Brings a store's ended runs to the fleet, each in one transaction: whole or not at all. What is there already is
// known by UUID and content hash and is not sent again, so that a push may die anywhere, be repeated, and go on beside
// another.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "db/fleet/copy_back.h"
#include "db/fleet/local_runs.h"
#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

struct Waiting {
  LocalRun run;
  bool content = false;  // the run itself; false: only what was said of it later
};

struct PushedRun {
  std::int64_t number = 0;  // in the fleet
  std::int64_t frames = 0;  // sent now
  int fits = 0;             // sent now
  bool remarks = false;     // a new revision was sent
};

inline constexpr std::uintmax_t kLargestScratch = 64 << 20;  // bytes

class Push {
 public:
  // `source`: names the store in the fleet, "host:/path/runs.db". `scratch`: an empty folder for what is read back,
  // which begins anew before a run when it is larger than `largest_scratch`.
  Push(Link& link, LocalRuns& store, std::string source, std::string scratch,
       std::uintmax_t largest_scratch = kLargestScratch);

  // What the fleet does not have, in the order of the runs; one query.
  std::vector<Waiting> waiting();
  // Sends it, reads it back within the transaction, and commits when the content hash of what the server holds is that
  // of the store. TB-FLEET-DIFFERS when it is not; nothing was changed then. StoreError when the store cannot be read.
  PushedRun push(const Waiting& waiting);
  int push_baselines();  // returns how many were sent

 private:
  struct InsertedRow;
  void add_sensor(std::int64_t run, InsertedRow& row);
  std::int64_t insert_run(const LocalRun& run, bool* is_new);
  std::int64_t send(const Table& table, std::int64_t number, const LocalRun& run);
  void compare(std::int64_t number, const LocalRun& run);
  int send_fits(std::int64_t number, std::int64_t run);
  bool send_remarks(std::int64_t number, const LocalRun& run);
  void send_rows(const Table& table, std::int64_t key, const std::vector<Row>& rows);

  Link& link_;
  LocalRuns& store_;
  std::string source_, scratch_;
  std::set<std::int64_t> months_;  // whose partitions are there
  std::map<std::int64_t, std::pair<std::string, std::string>> fit_names_;
  std::unique_ptr<CopyBack> read_back_;
  int scratch_files_ = 0;
  std::uintmax_t largest_scratch_;
};

// Adds a fit that was made in the fleet, on a run of it, in place of the fit with the hash `parent_sha256` ("": none).
// False when it is there already.
bool add_fit(Link& link, std::int64_t run, sqlite::Connection& store, std::int64_t fit_in_store,
             const std::string& parent_sha256);

}  // namespace tactbench::db::fleet
