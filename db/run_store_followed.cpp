// Records over time: figures, baselines, approved reports.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "db/run_store_database.h"

namespace tactbench::db {

void RunStore::replace_figures(std::int64_t run, const std::string& subject,
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

std::vector<FigureRecord> RunStore::figures(const std::string& subject) const {
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

std::map<std::int64_t, std::int64_t> RunStore::repeated_runs(const std::string& subject,
                                                             std::vector<std::int64_t> runs) const {
  std::map<std::int64_t, std::map<std::string, std::string>> values;  // as text: a value may be not-a-number
  std::set<std::int64_t> measured;  // runs with a figure that is no whole number: counts may be equal by right
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
    const auto same = by_content.find(content);
    const auto alike = by_figures.find(values[run]);
    if (!content.empty() && same != by_content.end()) {
      repeated[run] = same->second;
    } else if (measured.contains(run) && alike != by_figures.end()) {
      repeated[run] = alike->second;
    } else {
      by_content[content] = run;
      by_figures[values[run]] = run;
    }
  }
  return repeated;
}

std::int64_t RunStore::add_baseline(const BaselineRecord& baseline) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("store {}: the baseline of {} {}", path(), baseline.subject, what), remedy);
  };
  check_said("the baseline's reason", baseline.reason, kLongestText);
  check_said("the name of the person who accepts it", baseline.accepted_by, kLongestName);
  if (baseline.accepted_utc.empty())
    refuse("is not accepted without a date", "this is a defect of the caller: please report it");
  if (baseline.runs.empty()) refuse("names no run", "name the runs to accept");
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  std::set<std::string> origins;
  for (const std::int64_t number : baseline.runs) {
    const RunRecord run = database_->run(number);
    origins.insert(run.origin);
    if (run.is_void()) refuse(fmt::format("names run {}, which is void", number), "leave it out");
    sqlite::Statement own(connection, "SELECT 1 FROM figures WHERE run = ? AND subject = ? LIMIT 1");
    if (own.bind(number, baseline.subject).step()) continue;
    refuse(fmt::format("names run {}, which has no figures of it", number), "tactbench trend shows the runs that have");
  }
  if (origins.size() > 1) refuse("mixes simulated and real runs", "one origin a baseline");
  const std::set<std::int64_t> named(baseline.runs.begin(), baseline.runs.end());
  const auto repeated = repeated_runs(baseline.subject, baseline.runs);
  if (named.size() > 1 && repeated.size() + 1 == named.size()) {
    refuse(fmt::format("names {} runs that are all one measurement: run {} repeats run {} (the same seeds and content, "
                       "or the same figures), so that no figure has a spread",
                       named.size(), repeated.begin()->first, repeated.begin()->second),
           "accept runs that were measured separately, simulated ones with seeds of their own (--seed)");
  }
  sqlite::Statement(connection,
                    "INSERT INTO baselines (subject, reason, accepted_by, accepted_utc) VALUES (?, ?, ?, ?)")
      .bind(baseline.subject, baseline.reason, baseline.accepted_by, baseline.accepted_utc)
      .run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(connection, "INSERT INTO baseline_runs (baseline, run) VALUES (?, ?)");
  for (const std::int64_t run : named) row.bind(number, run).run();
  transaction.commit();
  return number;
}

std::vector<BaselineRecord> RunStore::baselines() const {
  sqlite::Statement rows(database_->connection,
                         "SELECT b.baseline, subject, reason, accepted_by, accepted_utc, r.run FROM baselines b "
                         "JOIN baseline_runs r ON r.baseline = b.baseline "
                         "ORDER BY accepted_utc, b.baseline, r.run");
  std::vector<BaselineRecord> baselines;
  while (rows.step()) {
    BaselineRecord row;
    rows.read(row.baseline, row.subject, row.reason, row.accepted_by, row.accepted_utc);
    if (baselines.empty() || baselines.back().baseline != row.baseline) baselines.push_back(row);
    baselines.back().runs.push_back(rows.value<std::int64_t>(5));
  }
  return baselines;
}

void RunStore::add_report(const ReportRecord& report) {
  check_said("the signer's name", report.approved_by, kLongestName);
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
                     fmt::format("report {} of run {} would replace '{}', and the one approved last is '{}'",
                                 report.number, report.run, report.replaces, last),
                     "another one was approved meanwhile: check that one, then approve again");
  }
  if (!report.replaces.empty()) {
    check_said("the reason why the report replaces another", report.reason, kLongestText);
  } else if (!report.reason.empty()) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("report {} replaces none, and a reason to replace one is stated", report.number),
                     "leave the reason out");
  }
  std::string evidence;
  for (const auto& [run, content] : report.evidence) evidence += fmt::format("{} {}\n", run, content);
  sqlite::Statement(database_->connection,
                    "INSERT INTO reports (run, number, content_sha256, approved_by, approved_utc, replaces, reason, "
                    "evidence) VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .bind(report.run, report.number, report.content_sha256, report.approved_by, report.approved_utc, report.replaces,
            report.reason, evidence)
      .run();
  seal(report.run, "approvals");
  transaction.commit();
}

namespace {

constexpr const char* kReportColumns =
    "SELECT run, number, content_sha256, approved_by, approved_utc, replaces, reason, evidence FROM reports";

std::vector<ReportRecord> report_rows(sqlite::Statement& rows) {
  std::vector<ReportRecord> reports;
  while (rows.step()) {
    ReportRecord& r = reports.emplace_back();
    std::string evidence;
    rows.read(r.run, r.number, r.content_sha256, r.approved_by, r.approved_utc, r.replaces, r.reason, evidence);
    std::istringstream lines(evidence);
    for (ReportRecord::Evidence one; lines >> one.run >> one.content_sha256;) r.evidence.push_back(one);
  }
  return reports;
}

}  // namespace

std::vector<ReportRecord> RunStore::reports(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, std::string(kReportColumns) + " WHERE run = ? ORDER BY report_row");
  rows.bind(run);
  return report_rows(rows);
}

std::vector<ReportRecord> RunStore::reports() const {
  sqlite::Statement rows(database_->connection, std::string(kReportColumns) + " ORDER BY report_row");
  return report_rows(rows);
}

}  // namespace tactbench::db
