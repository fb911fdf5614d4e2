// The fleet database: its tables, and runs in it: list, add, find and read them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "db/fleet/postgres.h"
#include "db/run_reader.h"

namespace tactbench::db::fleet {

// A run as it is pushed.
struct SentRun {
  std::string uuid, content_sha256;
  std::string said_sha256;  // hash of the content hash and of all records about the run
  std::string source;       // the store: "host:/path/runs.db"
  std::string facts;        // JSON
  std::string body;         // by pack_run()
};

// Identity of a row of the fleet, without its content; oldest first.
struct KnownRow {
  std::string uuid, content_sha256, said_sha256, source;
};
std::vector<KnownRow> known_rows(Link& link, const std::vector<std::string>& uuids);

// Sends the run, reads it back within the transaction, and commits if it equals what was sent; a run is never stored in
// part. Returns the fleet's number of the run, also if it was there already. TB-FLEET-DIFFERS, TB-FLEET-OWNER; nothing
// was changed then.
std::int64_t add_run(Link& link, const SentRun& run);

// The newest row of a run; `facts`: JSON from the bench.
struct FleetRun {
  std::int64_t run = 0, revision = 0;  // the fleet's number, and the order of all rows
  std::string uuid, content_sha256, facts, pushed_by, pushed_utc, source;
};

// Finds a run by the fleet's number, the UUID, or its first characters (four or more). TB-FLEET-NOT-FOUND.
FleetRun find_run_by_name(Link& link, const std::string& name);
// Runs of an origin, by start. `where`: a condition in SQL over the columns of the view fleet.every_run, evaluated
// read-only with the rights of the logged-in user, for at most a minute; empty: all. TB-FLEET-WHERE.
std::vector<FleetRun> find_runs(Link& link, const std::string& origin, const std::string& where);
std::map<std::string, std::int64_t> runs_by_origin(Link& link);
// The run and the runs that its models and verdicts are based on (rests_on of the facts), as far as the fleet has them.
std::vector<FleetRun> with_dependencies(Link& link, const FleetRun& run);
// The run's packed store, compared with its hash. TB-FLEET-CHANGED.
std::string body_of(Link& link, const FleetRun& run);

// Largest store of a run, in bytes: about a million frames of 16 x 16 taxels. A value in PostgreSQL is smaller than 1
// GiB.
inline constexpr std::size_t kMaxStoreBytes = 1'000'000'000;

// The body of a run: an SQLite store that holds only this run and everything stored about it, compressed with zlib.
// `scratch`: a temporary folder that nobody else uses. Throws StoreError if the run has changed since it was stored,
// FleetError TB-FLEET-LARGE.
std::string pack_run(const RunReader& store, std::int64_t run, const std::string& scratch);
// Writes the store to `path`. Throws FleetError TB-FLEET-CHANGED when `body` is not a packed run; the file is then
// unusable.
void unpack_run(const std::string& body, const std::string& path);

inline constexpr int kFleetSchema = 1;  // of tables, roles and views

// Version of the database's fleet schema; 0: it has none.
int schema_of(Link& link);
// TB-FLEET-EMPTY, and TB-FLEET-SCHEMA unless it is this program's.
void check_schema(Link& link);
// Makes tables, roles and views if there are none; returns the previous schema version. Several programs may do it at
// the same time. TB-FLEET-SCHEMA, TB-FLEET-TEXT if the database's encoding is not UTF8.
int make_fleet(Link& link, const std::string& program_version);

}  // namespace tactbench::db::fleet
