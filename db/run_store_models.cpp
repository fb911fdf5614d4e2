// Models and verdicts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "db/run_store_database.h"
#include "db/utf8.h"

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

std::optional<FitRecord> RunStore::default_fit(std::int64_t run) const {
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

// Nights, and what merging several stores needs to find.

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

std::int64_t RunStore::copy_baseline(const BaselineRecord& baseline) {
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

// People's remarks on a run: tags, notes, void.

namespace {

void check_tag(const std::string& tag) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._:/+-=").find(c) != std::string_view::npos;
  };
  const std::size_t equals = tag.find('=');  // of KEY=VALUE: one, with something on both sides
  const bool pair = equals == std::string::npos || (equals > 0 && equals + 1 < tag.size() && tag.rfind('=') == equals);
  if (!tag.empty() && tag.size() <= 64 && pair && std::ranges::all_of(tag, fits)) return;
  throw StoreError(
      "TB-STORE-TAG", fmt::format("'{}' is not a valid tag", tag),
      "a tag is one word of up to 64 letters, digits and . _ : / + -, or two with = between them (lot=A7); "
      "longer words go into a note");
}

}  // namespace

void check_text(const std::string& what, const std::string& text, std::size_t longest) {
  std::size_t characters = 0;
  for (std::string_view rest = text; !rest.empty(); ++characters) {
    const CodePoint c = decode_utf8(rest);
    if (!c.valid)
      throw StoreError("TB-STORE-NOT-TEXT", fmt::format("{} is not UTF-8", what), "type it again; nothing was stored");
    rest.remove_prefix(c.bytes);
  }
  if (characters <= longest) return;
  throw StoreError("TB-STORE-TOO-LONG",
                   fmt::format("{} has {} characters, at most {} are allowed", what, characters, longest),
                   "shorten it; nothing was stored");
}

void check_nonblank_text(const std::string& what, const std::string& text, std::size_t longest) {
  check_text(what, text, longest);
  if (!is_blank(text)) return;
  throw StoreError("TB-STORE-BLANK", fmt::format("{} is empty or blank", what),
                   "write what is to stand there; nothing was stored");
}

void RunStore::set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove) {
  for (const std::string& tag : add) check_tag(tag);
  for (const std::string& tag : remove) check_tag(tag);
  sqlite::Transaction transaction(database_->connection);
  const std::vector<std::string> before = database_->run(run).tags;
  std::set<std::string> tags(before.begin(), before.end());
  for (const std::string& tag : add) {
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)  // a key has one value
      std::erase_if(tags, [&](const std::string& old) { return old.starts_with(tag.substr(0, equals + 1)); });
    tags.insert(tag);
  }
  for (const std::string& tag : remove) tags.erase(tag);
  if (tags.size() > kMaxTags) {
    throw StoreError("TB-STORE-TAG",
                     fmt::format("run {} would have {} tags, at most {} are allowed", run, tags.size(), kMaxTags),
                     "remove some with --remove");
  }
  sqlite::Statement(database_->connection, "UPDATE runs SET tags = ? WHERE run = ?")
      .bind(fmt::format("{}", fmt::join(tags, " ")), run)
      .run();
  transaction.commit();
}

void RunStore::add_note(std::int64_t run, const std::string& text) {
  check_nonblank_text("the note", text, kMaxTextLength);
  sqlite::Transaction transaction(database_->connection);
  database_->require_run(run);
  sqlite::Statement(database_->connection,
                    "UPDATE runs SET notes = CASE notes WHEN '' THEN '' ELSE notes || char(10) END || ? WHERE run = ?")
      .bind(text, run)
      .run();
  transaction.commit();
}

void RunStore::void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} {}", path(), run, what), remedy);
  };
  check_nonblank_text("the reason", reason, kMaxTextLength);
  check_nonblank_text("the name of the person who voids it", by, kMaxNameLength);
  sqlite::Transaction transaction(database_->connection);
  const RunRecord record = database_->run(run);
  if (record.outcome == Outcome::kIncomplete) refuse("has not ended", "wait for its end, or stop it");
  if (record.is_void()) {
    refuse(fmt::format("is void already, by {} ({})", record.void_by, record.void_reason),
           "write additions into a note");
  }
  if (utc.empty()) refuse("is not made void without a date", "this is a defect of the caller: please report it");
  sqlite::Statement(database_->connection, "UPDATE runs SET void_reason = ?, void_by = ?, void_utc = ? WHERE run = ?")
      .bind(reason, by, utc, run)
      .run();
  seal(run, "void");
  transaction.commit();
}

}  // namespace tactbench::db
