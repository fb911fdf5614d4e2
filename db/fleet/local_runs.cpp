#include "db/fleet/local_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "db/run_store.h"

namespace tactbench::db::fleet {

namespace {

std::unique_ptr<sqlite::Connection> opened(const std::string& path) {
  const std::string file = std::filesystem::absolute(path).string();
  const auto open = [&](sqlite::Access access) {
    auto connection = std::make_unique<sqlite::Connection>(file, access);
    connection->trust_no_schema();
    (void)connection->integer("SELECT count(*) FROM sqlite_master");
    return connection;
  };
  try {
    return open(sqlite::Access::kReadOnly);
  } catch (const StoreError&) {
    if (std::filesystem::exists(file + "-wal")) throw;
    return open(sqlite::Access::kImmutable);  // a folder without write access: the file lies still
  }
}

}  // namespace

LocalRuns::LocalRuns(const std::string& path) : path_(path) {
  (void)RunStore::open_read_only(path);
  connection_ = opened(path);
}

std::vector<LocalRun> LocalRuns::ended_runs() {
  std::vector<LocalRun> runs;
  // A run whose frames were removed cannot be sent: the fleet recomputes its hash from them.
  sqlite::Statement rows(*connection_,
                         "SELECT run, uuid, content_sha256, started_utc, tags, notes, void_utc FROM runs "
                         "WHERE outcome <> 'incomplete' AND run NOT IN (SELECT run FROM pruned) ORDER BY run");
  sqlite::Statement seals(*connection_, "SELECT kind, count, sha256 FROM seals WHERE run = ? ORDER BY kind");
  sqlite::Statement figures(*connection_,
                            "SELECT subject, name, value FROM figures WHERE run = ? ORDER BY subject, name");
  const std::vector<Column> seal_columns = {{"kind", Kind::kText}, {"count", Kind::kInteger}, {"sha256", Kind::kText}};
  const std::vector<Column> figure_columns = {{"subject", Kind::kText}, {"name", Kind::kText}, {"value", Kind::kReal}};
  const std::vector<Column> own(5, {"", Kind::kText});
  Row row;
  while (rows.step()) {
    LocalRun& run = runs.emplace_back();
    Row said(5);
    rows.read(run.run, run.uuid, run.content_sha256, run.started_utc, said[0].bytes, said[1].bytes, said[2].bytes);
    said[3].bytes = run.uuid;
    said[4].bytes = run.content_sha256;
    std::string bytes;
    add_to_digest(bytes, own, said);
    for (const auto& [statement, columns] : {std::pair(&seals, &seal_columns), std::pair(&figures, &figure_columns)}) {
      statement->bind(run.run);
      while (statement->step()) {
        read_row(*statement, *columns, row);
        add_to_digest(bytes, *columns, row);
      }
      statement->reset();
    }
    run.fingerprint = sha256_hex(bytes);
  }
  return runs;
}

std::int64_t LocalRuns::frame_count(std::int64_t run) {
  sqlite::Statement row(*connection_,
                        "SELECT count(*) FROM frames WHERE frame > ?1 * 1000000000 AND frame < (?1 + 1) * 1000000000");
  return row.bind(run).first<std::int64_t>().value();
}

std::int64_t LocalRuns::version() { return connection_->integer("PRAGMA data_version"); }

PushedNote::PushedNote(const std::string& store_path, std::string fleet) : fleet_(std::move(fleet)) {
  try {
    connection_ = std::make_unique<sqlite::Connection>(std::filesystem::absolute(store_path + "-fleet").string(),
                                                       sqlite::Access::kReadWrite);
    connection_->execute(
        "PRAGMA synchronous = NORMAL; "
        "CREATE TABLE IF NOT EXISTS pushed (fleet TEXT NOT NULL, uuid TEXT NOT NULL, fingerprint TEXT NOT NULL, "
        "PRIMARY KEY (fleet, uuid)) STRICT; "
        "CREATE TABLE IF NOT EXISTS fleets (fleet TEXT PRIMARY KEY NOT NULL, pushed_utc TEXT NOT NULL, tried_utc TEXT "
        "NOT NULL, error TEXT NOT NULL) STRICT");
    sqlite::Statement(*connection_, "INSERT OR IGNORE INTO fleets VALUES (?, '', '', '')").bind(fleet_).run();
  } catch (const StoreError&) {
    connection_.reset();
  }
}

void PushedNote::keep(const LocalRun& run, const std::string& utc) {
  if (!connection_) return;
  try {
    sqlite::Transaction transaction(*connection_);
    sqlite::Statement(*connection_, "INSERT OR REPLACE INTO pushed VALUES (?, ?, ?)")
        .bind(fleet_, run.uuid, run.fingerprint)
        .run();
    sqlite::Statement(*connection_, "UPDATE fleets SET pushed_utc = ? WHERE fleet = ?").bind(utc, fleet_).run();
    transaction.commit();
  } catch (const StoreError&) {
    connection_.reset();
  }
}

void PushedNote::keep_try(const std::string& utc, const std::string& error) {
  if (!connection_) return;
  try {
    sqlite::Statement(*connection_, "UPDATE fleets SET tried_utc = ?, error = ? WHERE fleet = ?")
        .bind(utc, error, fleet_)
        .run();
  } catch (const StoreError&) {
    connection_.reset();
  }
}

std::map<std::string, std::string> PushedNote::fingerprints() {
  std::map<std::string, std::string> found;
  if (!connection_) return found;
  sqlite::Statement rows(*connection_, "SELECT uuid, fingerprint FROM pushed WHERE fleet = ?");
  rows.bind(fleet_);
  while (rows.step()) found[rows.value<std::string>(0)] = rows.value<std::string>(1);
  return found;
}

PushedNote::Last PushedNote::last() {
  Last last;
  if (!connection_) return last;
  sqlite::Statement row(*connection_, "SELECT pushed_utc, tried_utc, error FROM fleets WHERE fleet = ?");
  if (row.bind(fleet_).step()) row.read(last.pushed_utc, last.tried_utc, last.error);
  return last;
}

std::int64_t month_of(const std::string& utc) {
  const auto digits = [&](std::size_t from, std::size_t count) {
    return utc.size() >= from + count && std::all_of(utc.begin() + static_cast<std::ptrdiff_t>(from),
                                                     utc.begin() + static_cast<std::ptrdiff_t>(from + count),
                                                     [](unsigned char c) { return std::isdigit(c) != 0; });
  };
  if (!digits(0, 4) || !digits(5, 2) || utc[4] != '-') return 0;
  const int year = std::stoi(utc.substr(0, 4)), month = std::stoi(utc.substr(5, 2));
  return year < 1970 || month < 1 || month > 12 ? 0 : 100 * year + month;
}

}  // namespace tactbench::db::fleet
