// Models and verdicts.
#include <fmt/format.h>

#include <set>

#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

constexpr const char* kFitColumns =
    "SELECT fit, run, model, stands, fitted, document, made_by, program_version, created_utc FROM fits";

FitRecord fit_of(const sqlite::Statement& row) {
  FitRecord fit;
  row.read(fit.fit, fit.run, fit.model, fit.stands, fit.fitted, fit.document, fit.made_by, fit.program_version,
           fit.created_utc);
  return fit;
}

}  // namespace

std::int64_t RunStore::add_fit(const FitRecord& fit) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  database_->require_run(fit.run);
  sqlite::Statement(connection,
                    "INSERT INTO fits (run, model, stands, fitted, document, made_by, program_version, created_utc) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(fit.run, fit.model, fit.stands, fit.fitted, fit.document, fit.made_by, fit.program_version, fit.created_utc)
      .run();
  const std::int64_t number = connection.last_row();
  seal(fit.run, "fits");
  transaction.commit();
  return number;
}

std::optional<FitRecord> RunStore::standing_fit(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection,
                        std::string(kFitColumns) + " WHERE run = ? ORDER BY stands DESC, fit DESC LIMIT 1");
  return row.bind(run).step() ? std::optional(fit_of(row)) : std::nullopt;
}

FitRecord RunStore::fit(std::int64_t fit) const {
  sqlite::Statement row(database_->connection, std::string(kFitColumns) + " WHERE fit = ?");
  if (row.bind(fit).step()) return fit_of(row);
  std::string there;
  sqlite::Statement rows(database_->connection, "SELECT fit, run FROM fits ORDER BY fit");
  while (rows.step()) {
    there += fmt::format("{}{} (run {})", there.empty() ? "" : ", ", rows.value<std::int64_t>(0),
                         rows.value<std::int64_t>(1));
  }
  throw StoreError("TB-STORE-NOT-FOUND",
                   fmt::format("store {} has no fit {}; it has {}", path(), fit, there.empty() ? "none yet" : there),
                   "make one: tactbench fit RUN");
}

std::vector<FitRecord> RunStore::fits(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, std::string(kFitColumns) + " WHERE run = ? ORDER BY fit");
  rows.bind(run);
  std::vector<FitRecord> fits;
  while (rows.step()) fits.push_back(fit_of(rows));
  return fits;
}

void RunStore::replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  database_->require_run(run);
  if (fit != 0) static_cast<void>(this->fit(fit));
  // Verdicts are replaced per model and run: the same model fitted on the same run again takes the earlier fit's place.
  sqlite::Statement before(connection,
                           "DELETE FROM verdicts WHERE run = ? AND limits_sha256 = ? AND coalesce((SELECT f.run || ' ' "
                           "|| f.stands || f.model "
                           "FROM fits f WHERE f.fit = verdicts.fit), 0) = coalesce((SELECT run || ' ' || stands || "
                           "model FROM fits WHERE fit "
                           "= ?), 0)");
  std::set<std::string> limits;
  for (const VerdictRecord& v : verdicts) limits.insert(v.limits_sha256);
  for (const std::string& sha256 : limits) before.bind(run, sha256, fit).run();
  sqlite::Statement row(connection,
                        "INSERT INTO verdicts (run, fit, criterion, scope_kind, low_psi, high_psi, direction, "
                        "taxel_share, value, expanded, limit_value, unit, rule, verdict, limits_toml, limits_sha256) "
                        "VALUES (?, nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const VerdictRecord& v : verdicts) {
    row.bind(run, fit, v.criterion, v.scope_kind, v.low_psi, v.high_psi, v.direction, v.share, v.value, v.expanded,
             v.limit, v.unit, v.rule, v.verdict, v.limits_toml, v.limits_sha256)
        .run();
  }
  seal(run, "verdicts");
  transaction.commit();
}

namespace {

std::vector<VerdictRecord> verdict_rows(sqlite::Connection& connection, const char* where, std::int64_t run) {
  sqlite::Statement rows(connection,
                         fmt::format("SELECT v.run, v.fit, v.criterion, v.scope_kind, v.low_psi, v.high_psi, "
                                     "v.direction, v.taxel_share, v.value, v.expanded, v.limit_value, v.unit, v.rule, "
                                     "v.verdict, v.limits_toml, v.limits_sha256, coalesce(f.run, 0) FROM verdicts v "
                                     "LEFT JOIN fits f ON f.fit = v.fit WHERE {} = ? ORDER BY v.verdict_row",
                                     where));
  rows.bind(run);
  std::vector<VerdictRecord> verdicts;
  while (rows.step()) {
    VerdictRecord& v = verdicts.emplace_back();
    rows.read(v.run, v.fit, v.criterion, v.scope_kind, v.low_psi, v.high_psi, v.direction, v.share, v.value, v.expanded,
              v.limit, v.unit, v.rule, v.verdict, v.limits_toml, v.limits_sha256, v.model_run);
  }
  return verdicts;
}

}  // namespace

std::vector<VerdictRecord> RunStore::verdicts(std::int64_t run) const {
  database_->require_run(run);
  return verdict_rows(database_->connection, "v.run", run);
}

std::vector<VerdictRecord> RunStore::verdicts_of_models(std::int64_t run) const {
  database_->require_run(run);
  return verdict_rows(database_->connection, "f.run", run);
}

}  // namespace tactbench::db
