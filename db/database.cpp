#include "db/database.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "db/models.h"
#include "db/run_reader.h"
#include "db/store_error.h"

namespace tactbench::db {

namespace {

// 1, 2, 3, 7 -> "1-3, 7"
std::string ranges(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (!text.empty()) text += ", ";
    text += last == i ? std::to_string(numbers[i]) : fmt::format("{}-{}", numbers[i], numbers[last]);
    i = last + 1;
  }
  return text;
}

}  // namespace

void Database::require_run(std::int64_t run) {
  {
    sqlite::Statement row(connection, "SELECT 1 FROM runs WHERE run = ?");
    if (row.bind(run).step()) return;
  }
  std::vector<std::int64_t> numbers;
  sqlite::Statement rows(connection, "SELECT run FROM runs ORDER BY run");
  while (rows.step()) rows.read(numbers.emplace_back());
  throw StoreError("TB-STORE-NOT-FOUND",
                   fmt::format("store {} has no run {}; {}", path, run,
                               numbers.empty() ? "it has none yet" : "it has " + ranges(numbers)),
                   "see 'tactbench runs list', or name another store with --db");
}

Database::OpenRun& Database::open_run(std::int64_t run) {
  const auto known = open_runs.find(run);
  if (known != open_runs.end()) return known->second;
  require_run(run);
  OpenRun open;
  const auto outcome = sqlite::Statement(connection, "SELECT outcome FROM runs WHERE run = ? AND state = 'ended'")
                           .bind(run)
                           .first<std::string>();
  if (outcome) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("store {}: run {} has ended ({}) and accepts no more data", path, run, *outcome),
                     "start a new run");
  }
  sqlite::Statement last(connection,
                         "SELECT frame, chain FROM frames WHERE frame > ? AND frame < ? "
                         "ORDER BY frame DESC LIMIT 1");
  if (last.bind(frames_above(run), frames_below(run)).step()) {
    last.read(open.frames, open.chain.emplace());
    open.frames -= frames_above(run);
  }
  return open_runs.emplace(run, open).first->second;
}

void Database::require_open(std::int64_t run) {
  sqlite::Statement row(connection, "SELECT 1 FROM runs WHERE run = ? AND state <> 'ended'");
  if (row.bind(run).step()) return;
  open_runs.erase(run);
  throw StoreError("TB-STORE-CONFLICT",
                   fmt::format("store {}: run {} was ended by another process and accepts no more data", path, run),
                   "tactbench runs show shows how it ended; tactbench resume continues it");
}

const BranchRecord& Database::branch_of(std::int64_t run, std::int64_t branch) {
  if (last_branch_run == run && last_branch.branch == branch) return last_branch;
  sqlite::Statement row(connection,
                        "SELECT branch, sequence, \"repeat\", ordinal, attempt, void FROM branches "
                        "WHERE branch = ? AND run = ?");
  if (!row.bind(branch, run).step()) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} has no branch {}", path, run, branch),
                     "begin the branch first");
  }
  BranchRecord found;
  row.read(found.branch, found.sequence, found.repeat, found.ordinal, found.attempt, found.is_void);
  if (found.is_void) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: branch {} of run {} is void", path, branch, run),
                     "begin the branch again with the next attempt");
  }
  last_branch = found;
  last_branch_run = run;
  return last_branch;
}

// Only through SQLite: pages of a transaction that do not fit its cache go to the log before the commit. After a
// rollback they are unused, but the file keeps its length.
void Database::preallocate_log() {
  constexpr std::uintmax_t kLongest = 1000 * (4096 + 24) + 32;
  constexpr int kFullSync = 2;
  std::error_code missing;
  const std::uintmax_t now = std::filesystem::file_size(connection.path() + "-wal", missing);
  if ((!missing && now >= kLongest) || connection.integer("PRAGMA synchronous") != kFullSync) return;
  const std::int64_t cache = connection.integer("PRAGMA cache_size");
  connection.execute("PRAGMA cache_size = 16");
  try {
    const sqlite::Transaction never_committed(connection);
    connection.execute("CREATE TABLE longer (bytes BLOB); INSERT INTO longer VALUES (zeroblob(4200000))");
  } catch (const StoreError&) {  // a full disk reports it at the next write
  }
  connection.execute(fmt::format("PRAGMA cache_size = {}", cache));
}

Seal Database::seal_now(std::int64_t run, const std::string& kind) {
  if (kind == "fits") {
    const std::vector<FitRecord> rows = Models(*this).fits(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.fits(rows))};
  }
  if (kind == "verdicts") {
    const std::vector<VerdictRecord> rows = Models(*this).verdicts(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.verdicts(rows))};
  }
  if (kind == "approvals") {
    const std::vector<ReportRecord> rows = Models(*this).reports(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.approvals(rows))};
  }
  const RunRecord record = RunReader(*this).run(run);
  return {record.is_void() ? 1 : 0, hex(hasher.voided(record))};
}

void Database::seal(std::int64_t run, const std::string& kind) {
  const Seal now = seal_now(run, kind);
  sqlite::Statement(connection,
                    "INSERT INTO seals (run, kind, count, sha256) VALUES (?, ?, ?, ?) "
                    "ON CONFLICT (run, kind) DO UPDATE SET count = excluded.count, sha256 = excluded.sha256")
      .bind(run, kind, now.count, now.sha256)
      .run();
}

}  // namespace tactbench::db
