#include "db/models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "db/database.h"
#include "db/remarks.h"
#include "db/run_reader.h"
#include "db/store_error.h"

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

std::int64_t Models::add_fit(const FitRecord& fit) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  database_->require_run(fit.run);
  sqlite::Statement(connection, sqlite::insert_into("fits", fmt::format("run, {}", FitRecord::kColumns)))
      .bind(fit.run, fit.row())
      .run();
  const std::int64_t number = connection.last_row();
  database_->seal(fit.run, "fits");
  transaction.commit();
  return number;
}

std::optional<FitRecord> Models::default_fit(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection, select_fits("WHERE run = ? ORDER BY stands DESC, fit DESC LIMIT 1"));
  return row.bind(run).step() ? std::optional(fit_of(row)) : std::nullopt;
}

FitRecord Models::fit(std::int64_t fit) const {
  sqlite::Statement row(database_->connection, select_fits("WHERE fit = ?"));
  if (row.bind(fit).step()) return fit_of(row);
  std::string there;
  sqlite::Statement rows(database_->connection, "SELECT fit, run FROM fits ORDER BY fit");
  while (rows.step()) {
    there += fmt::format("{}{} (run {})", there.empty() ? "" : ", ", rows.value<std::int64_t>(0),
                         rows.value<std::int64_t>(1));
  }
  throw StoreError(
      "TB-STORE-NOT-FOUND",
      fmt::format("store {} has no fit {}; it has {}", database_->path, fit, there.empty() ? "none yet" : there),
      "make one: tactbench fit RUN");
}

std::vector<FitRecord> Models::fits(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, select_fits("WHERE run = ? ORDER BY fit"));
  rows.bind(run);
  std::vector<FitRecord> fits;
  while (rows.step()) fits.push_back(fit_of(rows));
  return fits;
}

void Models::replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts) {
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
  database_->seal(run, "verdicts");
  transaction.commit();
}

void Models::link_verdicts(std::int64_t run, const std::vector<std::int64_t>& fits) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  std::vector<std::int64_t> keys;
  {
    sqlite::Statement rows(connection, "SELECT rowid FROM verdicts WHERE run = ? ORDER BY rowid");
    rows.bind(run);
    while (rows.step()) keys.push_back(rows.value<std::int64_t>());
  }
  sqlite::Statement link(connection, "UPDATE verdicts SET fit = ? WHERE rowid = ?");
  for (std::size_t i = 0; i < std::min(keys.size(), fits.size()); ++i)
    if (fits[i] != 0) link.bind(fits[i], keys[i]).run();
  database_->seal(run, "verdicts");
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

std::vector<VerdictRecord> Models::verdicts(std::int64_t run) const {
  database_->require_run(run);
  return verdict_rows(database_->connection, "v.run", run);
}

std::vector<VerdictRecord> Models::verdicts_of_models(std::int64_t run) const {
  database_->require_run(run);
  return verdict_rows(database_->connection, "f.run", run);
}

// Figures over time, and baselines.

void Models::replace_figures(std::int64_t run, const std::string& subject,
                             const std::map<std::string, double>& figures) {
  sqlite::Transaction transaction(database_->connection);
  database_->require_run(run);
  sqlite::Statement(database_->connection, "DELETE FROM figures WHERE run = ? AND subject = ?")
      .bind(run, subject)
      .run();
  sqlite::Statement row(database_->connection, "INSERT INTO figures (run, subject, name, value) VALUES (?, ?, ?, ?)");
  for (const auto& [name, value] : figures) row.bind(run, subject, name, value).run();
  transaction.commit();
}

std::vector<FigureRecord> Models::figures(const std::string& subject) const {
  sqlite::Statement rows(database_->connection,
                         "SELECT f.run, f.subject, f.name, f.value, r.origin, r.seed, r.sensor_seed FROM figures f "
                         "JOIN runs r ON r.run = f.run "
                         "WHERE r.void_utc = '' AND (?1 = '' OR f.subject = ?1) ORDER BY f.run, f.subject, f.name");
  rows.bind(subject);
  std::vector<FigureRecord> figures;
  while (rows.step()) {
    FigureRecord& figure = figures.emplace_back();
    rows.read(figure.run, figure.subject, figure.name, figure.value, figure.origin, figure.seed, figure.sensor_seed);
  }
  return figures;
}

std::vector<std::string> Models::subjects() const {
  // Each subject is found by the index, whatever the number of its figures.
  sqlite::Statement rows(database_->connection,
                         "WITH RECURSIVE own (subject) AS (SELECT min(subject) FROM figures UNION ALL "
                         "SELECT (SELECT min(subject) FROM figures f WHERE f.subject > own.subject) FROM own "
                         "WHERE own.subject IS NOT NULL) SELECT subject FROM own WHERE subject IS NOT NULL");
  std::vector<std::string> subjects;
  while (rows.step()) rows.read(subjects.emplace_back());
  return subjects;
}

std::vector<std::string> Models::subjects_of(std::int64_t run) const {
  sqlite::Statement rows(database_->connection, "SELECT DISTINCT subject FROM figures WHERE run = ? ORDER BY subject");
  rows.bind(run);
  std::vector<std::string> subjects;
  while (rows.step()) rows.read(subjects.emplace_back());
  return subjects;
}

std::map<std::string, double> Models::figures_of(std::int64_t run, const std::string& subject) const {
  sqlite::Statement rows(database_->connection, "SELECT name, value FROM figures WHERE run = ? AND subject = ?");
  rows.bind(run, subject);
  std::map<std::string, double> figures;
  while (rows.step()) figures[rows.value<std::string>(0)] = rows.value<double>(1);
  return figures;
}

std::int64_t Models::last_run_of(const std::string& subject, std::int64_t seed, std::int64_t sensor_seed,
                                 std::int64_t before) const {
  sqlite::Statement row(database_->connection,
                        "SELECT coalesce(max(r.run), 0) FROM runs r WHERE r.seed = ? AND r.sensor_seed = ? AND "
                        "r.run < ? AND r.void_utc = '' AND EXISTS (SELECT 1 FROM figures f WHERE f.run = r.run AND "
                        "f.subject = ?)");
  return row.bind(seed, sensor_seed, before, subject).first<std::int64_t>().value();
}

std::map<std::int64_t, std::int64_t> Models::repeated_runs(const std::string& subject,
                                                           std::vector<std::int64_t> runs) const {
  std::map<std::int64_t, std::map<std::string, std::string>> values;  // as text: a value may be not-a-number
  std::set<std::int64_t>
      measured;  // runs with a figure that is not a whole number: equal counts do not prove a repetition
  for (const FigureRecord& figure : figures(subject)) {
    values[figure.run][figure.name] = fmt::format("{}", figure.value);
    if (figure.value != std::round(figure.value)) measured.insert(figure.run);
  }
  std::ranges::sort(runs);
  runs.erase(std::ranges::unique(runs).begin(), runs.end());
  std::map<std::int64_t, std::int64_t> repeated;
  std::map<std::string, std::int64_t> by_content;
  std::map<std::map<std::string, std::string>, std::int64_t> by_figures;
  for (const std::int64_t run : runs) {
    sqlite::Statement row(database_->connection, "SELECT content_sha256 FROM runs WHERE run = ?");
    const std::string content = row.bind(run).first<std::string>().value_or("");
    const auto same_content = by_content.find(content);
    const auto same_figures = by_figures.find(values[run]);
    if (!content.empty() && same_content != by_content.end()) {
      repeated[run] = same_content->second;
    } else if (measured.contains(run) && same_figures != by_figures.end()) {
      repeated[run] = same_figures->second;
    } else {
      by_content[content] = run;
      by_figures[values[run]] = run;
    }
  }
  return repeated;
}

namespace {

std::int64_t insert_baseline(sqlite::Connection& connection, const BaselineRecord& baseline,
                             const std::set<std::int64_t>& runs) {
  sqlite::Statement(connection, sqlite::insert_into("baselines", BaselineRecord::kColumns)).bind(baseline.row()).run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection, "INSERT INTO baseline_runs (baseline, run) VALUES (?, ?)");
  for (const std::int64_t run : runs) row.bind(number, run).run();
  return number;
}

}  // namespace

std::int64_t Models::add_baseline(const BaselineRecord& baseline) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("store {}: the baseline of {} {}", database_->path, baseline.subject, what), remedy);
  };
  check_nonblank_text("the baseline's reason", baseline.reason, kMaxTextLength);
  check_nonblank_text("the name of the person who accepts it", baseline.accepted_by, kMaxNameLength);
  if (baseline.accepted_utc.empty())
    refuse("is not accepted without a date", "this is a defect of the caller: please report it");
  if (baseline.runs.empty()) refuse("names no run", "name the runs to accept");
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  std::set<std::string> origins;
  for (const std::int64_t number : baseline.runs) {
    const RunRecord run = RunReader(*database_).run(number);
    origins.insert(run.origin);
    if (run.is_void()) refuse(fmt::format("names run {}, which is void", number), "leave it out");
    sqlite::Statement own(connection, "SELECT 1 FROM figures WHERE run = ? AND subject = ? LIMIT 1");
    if (own.bind(number, baseline.subject).step()) continue;
    refuse(fmt::format("names run {}, which has no figures of it", number), "tactbench trend shows the runs that have");
  }
  if (origins.size() > 1) refuse("mixes simulated and real runs", "use runs of one origin for a baseline");
  const std::set<std::int64_t> named(baseline.runs.begin(), baseline.runs.end());
  const auto repeated = repeated_runs(baseline.subject, baseline.runs);
  if (named.size() > 1 && repeated.size() + 1 == named.size()) {
    refuse(fmt::format(
               "names {} runs that are all the same measurement: run {} repeats run {} (the same seeds and content, "
               "or the same figures), so that no figure has a spread",
               named.size(), repeated.begin()->first, repeated.begin()->second),
           "accept runs that were measured separately, simulated ones with different seeds (--seed)");
  }
  const std::int64_t number = insert_baseline(database_->connection, baseline, named);
  transaction.commit();
  return number;
}

std::int64_t Models::copy_baseline(const BaselineRecord& baseline) {
  sqlite::Transaction transaction(database_->connection);
  const std::int64_t number =
      insert_baseline(database_->connection, baseline, {baseline.runs.begin(), baseline.runs.end()});
  transaction.commit();
  return number;
}

std::vector<BaselineRecord> Models::baselines() const {
  sqlite::Statement rows(database_->connection, fmt::format("SELECT r.run, b.baseline, {} FROM baselines b "
                                                            "JOIN baseline_runs r ON r.baseline = b.baseline "
                                                            "ORDER BY accepted_utc, b.baseline, r.run",
                                                            BaselineRecord::kColumns));
  std::vector<BaselineRecord> baselines;
  while (rows.step()) {
    BaselineRecord row;
    rows.read_from(1, row.baseline, row.row());
    if (baselines.empty() || baselines.back().baseline != row.baseline) baselines.push_back(row);
    baselines.back().runs.push_back(rows.value<std::int64_t>(0));
  }
  return baselines;
}

std::optional<BaselineRecord> Models::last_baseline(const std::string& subject) const {
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

// Approved reports.

namespace {

std::string select_reports(const std::string& rest) {
  return fmt::format("SELECT run, reason, evidence, {} FROM reports {}", ReportRecord::kColumns, rest);
}

std::vector<ReportRecord> report_rows(sqlite::Statement& rows) {
  std::vector<ReportRecord> reports;
  while (rows.step()) {
    ReportRecord& r = reports.emplace_back();
    std::string evidence;
    rows.read(r.run, r.reason, evidence, r.row());
    std::istringstream lines(evidence);
    for (ReportRecord::Evidence one; lines >> one.run >> one.content_sha256;) r.evidence.push_back(one);
  }
  return reports;
}

}  // namespace

void Models::add_report(const ReportRecord& report) {
  check_nonblank_text("the signer's name", report.approved_by, kMaxNameLength);
  sqlite::Transaction transaction(database_->connection);
  database_->require_run(report.run);
  const std::vector<ReportRecord> before = reports(report.run);
  for (const ReportRecord& there : before) {
    if (there.number != report.number) continue;
    throw StoreError(
        "TB-STORE-CONFLICT",
        fmt::format("report {} is approved already, by {} on {}", there.number, there.approved_by, there.approved_utc),
        "a report is approved once; it is the same document");
  }
  const std::string last = before.empty() ? std::string() : before.back().number;
  if (report.replaces != last) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("report {} of run {} would replace '{}', but the one approved last is '{}'",
                                 report.number, report.run, report.replaces, last),
                     "another one was approved meanwhile: check that one, then approve again");
  }
  if (!report.replaces.empty()) {
    check_nonblank_text("the reason why the report replaces another", report.reason, kMaxTextLength);
  } else if (!report.reason.empty()) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("report {} replaces none, but a reason to replace one is stated", report.number),
                     "leave the reason out");
  }
  std::string evidence;
  for (const auto& [run, content] : report.evidence) evidence += fmt::format("{} {}\n", run, content);
  sqlite::Statement(database_->connection,
                    sqlite::insert_into("reports", fmt::format("run, reason, evidence, {}", ReportRecord::kColumns)))
      .bind(report.run, report.reason, evidence, report.row())
      .run();
  database_->seal(report.run, "approvals");
  transaction.commit();
}

std::vector<ReportRecord> Models::reports(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, select_reports("WHERE run = ? ORDER BY report_row"));
  rows.bind(run);
  return report_rows(rows);
}

std::vector<ReportRecord> Models::reports() const {
  sqlite::Statement rows(database_->connection, select_reports("ORDER BY report_row"));
  return report_rows(rows);
}

}  // namespace tactbench::db
