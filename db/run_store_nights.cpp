// Nights, and what merging several stores needs to find.
#include <fmt/format.h>

#include "db/run_store_database.h"

namespace tactbench::db {

std::int64_t RunStore::add_night(const NightRecord& night) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  sqlite::Statement(connection,
                    "INSERT INTO nights (suite, suite_file, suite_toml, selection_json, shard, shards, begun_utc, "
                    "ended_utc, program) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(night.suite, night.suite_file, night.suite_toml, night.selection_json, night.shard, night.shards,
            night.begun_utc, night.ended_utc, night.program)
      .run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection,
                        "INSERT INTO night_results (night, position, label, first_run, result_json) "
                        "VALUES (?, ?, ?, nullif(?, 0), ?)");
  for (const NightResultRecord& result : night.results)
    row.bind(number, result.position, result.label, result.first_run, result.json).run();
  transaction.commit();
  return number;
}

std::vector<NightRecord> RunStore::nights() const {
  std::vector<NightRecord> nights;
  sqlite::Statement rows(database_->connection,
                         "SELECT night, suite, suite_file, suite_toml, selection_json, shard, shards, begun_utc, "
                         "ended_utc, program FROM nights ORDER BY night");
  while (rows.step()) {
    NightRecord& n = nights.emplace_back();
    rows.read(n.night, n.suite, n.suite_file, n.suite_toml, n.selection_json, n.shard, n.shards, n.begun_utc,
              n.ended_utc, n.program);
  }
  for (NightRecord& night : nights) {
    sqlite::Statement results(database_->connection,
                              "SELECT position, label, coalesce(first_run, 0), result_json FROM night_results "
                              "WHERE night = ? ORDER BY position");
    results.bind(night.night);
    while (results.step()) {
      NightResultRecord& r = night.results.emplace_back();
      results.read(r.position, r.label, r.first_run, r.json);
    }
  }
  return nights;
}

std::int64_t RunStore::run_of_uuid(const std::string& uuid) const {
  sqlite::Statement row(database_->connection, "SELECT run FROM runs WHERE uuid = ?");
  return row.bind(uuid).first<std::int64_t>().value_or(0);
}

std::int64_t RunStore::last_run_of(const std::string& subject, std::int64_t seed, std::int64_t sensor_seed,
                                   std::int64_t before) const {
  sqlite::Statement row(database_->connection,
                        "SELECT coalesce(max(r.run), 0) FROM runs r WHERE r.seed = ? AND r.sensor_seed = ? AND "
                        "r.run < ? AND r.void_utc = '' AND EXISTS (SELECT 1 FROM figures f WHERE f.run = r.run AND "
                        "f.subject = ?)");
  return row.bind(seed, sensor_seed, before, subject).first<std::int64_t>().value();
}

std::vector<std::string> RunStore::subjects() const {
  // Each subject is found by the index, whatever the number of its figures.
  sqlite::Statement rows(database_->connection,
                         "WITH RECURSIVE own (subject) AS (SELECT min(subject) FROM figures UNION ALL "
                         "SELECT (SELECT min(subject) FROM figures f WHERE f.subject > own.subject) FROM own "
                         "WHERE own.subject IS NOT NULL) SELECT subject FROM own WHERE subject IS NOT NULL");
  std::vector<std::string> subjects;
  while (rows.step()) rows.read(subjects.emplace_back());
  return subjects;
}

std::vector<std::string> RunStore::subjects_of(std::int64_t run) const {
  sqlite::Statement rows(database_->connection, "SELECT DISTINCT subject FROM figures WHERE run = ? ORDER BY subject");
  rows.bind(run);
  std::vector<std::string> subjects;
  while (rows.step()) rows.read(subjects.emplace_back());
  return subjects;
}

std::map<std::string, double> RunStore::figures_of(std::int64_t run, const std::string& subject) const {
  sqlite::Statement rows(database_->connection, "SELECT name, value FROM figures WHERE run = ? AND subject = ?");
  rows.bind(run, subject);
  std::map<std::string, double> figures;
  while (rows.step()) figures[rows.value<std::string>(0)] = rows.value<double>(1);
  return figures;
}

std::int64_t RunStore::take_baseline(const BaselineRecord& baseline) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  sqlite::Statement(connection,
                    "INSERT INTO baselines (subject, reason, accepted_by, accepted_utc) VALUES (?, ?, ?, ?)")
      .bind(baseline.subject, baseline.reason, baseline.accepted_by, baseline.accepted_utc)
      .run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection, "INSERT INTO baseline_runs (baseline, run) VALUES (?, ?)");
  for (const std::int64_t run : baseline.runs) row.bind(number, run).run();
  transaction.commit();
  return number;
}

std::optional<BaselineRecord> RunStore::last_baseline(const std::string& subject) const {
  sqlite::Statement row(database_->connection,
                        "SELECT baseline, subject, reason, accepted_by, accepted_utc FROM baselines WHERE subject = ? "
                        "ORDER BY accepted_utc DESC, baseline DESC LIMIT 1");
  if (!row.bind(subject).step()) return std::nullopt;
  BaselineRecord baseline;
  row.read(baseline.baseline, baseline.subject, baseline.reason, baseline.accepted_by, baseline.accepted_utc);
  sqlite::Statement runs(database_->connection, "SELECT run FROM baseline_runs WHERE baseline = ? ORDER BY run");
  runs.bind(baseline.baseline);
  while (runs.step()) runs.read(baseline.runs.emplace_back());
  return baseline;
}

}  // namespace tactbench::db
