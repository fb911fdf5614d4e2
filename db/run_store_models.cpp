// Models and verdicts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "db/run_store_database.h"
#include "db/utf8.h"

namespace tactbench::db {

namespace {

std::string select_fits(const std::string& rest) {
  return fmt::format("SELECT fit, run, {} FROM fits {}", FitRecord::kColumns, rest);
}

FitRecord fit_of(const sqlite::Statement& row) {
  FitRecord fit;
  row.read(fit.fit, fit.run, fit.row());
  return fit;
}

}  // namespace

std::int64_t RunStore::add_fit(const FitRecord& fit) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  database_->require_run(fit.run);
  sqlite::Statement(connection, sqlite::insert_into("fits", fmt::format("run, {}", FitRecord::kColumns)))
      .bind(fit.run, fit.row())
      .run();
  const std::int64_t number = connection.last_row();
  seal(fit.run, "fits");
  transaction.commit();
  return number;
}

std::optional<FitRecord> RunStore::default_fit(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection, select_fits("WHERE run = ? ORDER BY stands DESC, fit DESC LIMIT 1"));
  return row.bind(run).step() ? std::optional(fit_of(row)) : std::nullopt;
}

FitRecord RunStore::fit(std::int64_t fit) const {
  sqlite::Statement row(database_->connection, select_fits("WHERE fit = ?"));
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
  sqlite::Statement rows(database_->connection, select_fits("WHERE run = ? ORDER BY fit"));
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
                        sqlite::insert_into("verdicts", fmt::format("run, fit, {}", VerdictRecord::kColumns), "fit"));
  for (const VerdictRecord& v : verdicts) row.bind(run, fit, v.row()).run();
  seal(run, "verdicts");
  transaction.commit();
}

namespace {

std::vector<VerdictRecord> verdict_rows(sqlite::Connection& connection, const char* where, std::int64_t run) {
  sqlite::Statement rows(connection,
                         fmt::format("SELECT v.run, v.fit, f.run, {} FROM verdicts v "
                                     "LEFT JOIN fits f ON f.fit = v.fit WHERE {} = ? ORDER BY v.verdict_row",
                                     VerdictRecord::kColumns, where));
  rows.bind(run);
  std::vector<VerdictRecord> verdicts;
  while (rows.step()) {
    VerdictRecord& v = verdicts.emplace_back();
    rows.read(v.run, v.fit, v.model_run, v.row());
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
  sqlite::Statement(connection, sqlite::insert_into("nights", NightRecord::kColumns)).bind(night.row()).run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(
      connection,
      sqlite::insert_into("night_results", fmt::format("night, {}", NightResultRecord::kColumns), "first_run"));
  for (const NightResultRecord& result : night.results) row.bind(number, result.row()).run();
  transaction.commit();
  return number;
}

std::vector<NightRecord> RunStore::nights() const {
  std::vector<NightRecord> nights;
  sqlite::Statement rows(database_->connection,
                         fmt::format("SELECT night, {} FROM nights ORDER BY night", NightRecord::kColumns));
  while (rows.step()) {
    NightRecord& night = nights.emplace_back();
    rows.read(night.night, night.row());
  }
  for (NightRecord& night : nights)
    night.results = sqlite::read_all<NightResultRecord>(database_->connection,
                                                        "night_results WHERE night = ? ORDER BY position", night.night);
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

std::int64_t RunStore::Database::insert_baseline(const BaselineRecord& baseline, const std::set<std::int64_t>& runs) {
  sqlite::Statement(connection, sqlite::insert_into("baselines", BaselineRecord::kColumns)).bind(baseline.row()).run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection, "INSERT INTO baseline_runs (baseline, run) VALUES (?, ?)");
  for (const std::int64_t run : runs) row.bind(number, run).run();
  return number;
}

std::int64_t RunStore::copy_baseline(const BaselineRecord& baseline) {
  sqlite::Transaction transaction(database_->connection);
  const std::int64_t number = database_->insert_baseline(baseline, {baseline.runs.begin(), baseline.runs.end()});
  transaction.commit();
  return number;
}

std::optional<BaselineRecord> RunStore::last_baseline(const std::string& subject) const {
  sqlite::Statement row(database_->connection, fmt::format("SELECT baseline, {} FROM baselines WHERE subject = ? "
                                                           "ORDER BY accepted_utc DESC, baseline DESC LIMIT 1",
                                                           BaselineRecord::kColumns));
  if (!row.bind(subject).step()) return std::nullopt;
  BaselineRecord baseline;
  row.read(baseline.baseline, baseline.row());
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
  throw StoreError("TB-STORE-TAG", fmt::format("'{}' is not a valid tag", tag),
                   "a tag is one word of up to 64 letters, digits and . _ : / + -, or two joined by = (lot=A7); "
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
  throw StoreError("TB-STORE-BLANK", fmt::format("{} is empty or blank", what), "give the text; nothing was stored");
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
