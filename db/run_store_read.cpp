// Reading runs back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

std::string select_runs(const std::string& rest) {
  return fmt::format("SELECT run, {}, {}, {}, outcome, safe_state, tags FROM runs {}", RunRecord::kContent,
                     RunRecord::kBegun, RunRecord::kLater, rest);
}

RunRecord run_of(const sqlite::Statement& row) {
  RunRecord r;
  std::string outcome, safe_state, tags;
  row.read(r.run, r.content(), r.begun(), r.later(), outcome, safe_state, tags);
  std::istringstream words(tags);
  for (std::string tag; words >> tag;) r.tags.push_back(tag);
  const auto known_outcome = outcome_from(outcome);
  const auto known_state = safe_state_from(safe_state);
  if (!known_outcome || !known_state) {
    throw StoreError("TB-STORE-SQL",
                     fmt::format("run {} has the outcome '{}' and the safe state '{}'", r.run, outcome, safe_state),
                     "another program changed the file: restore your last snapshot");
  }
  r.outcome = *known_outcome;
  r.safe_state = *known_state;
  return r;
}

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

void RunStore::Database::require_run(std::int64_t run) {
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

RunRecord RunStore::Database::run(std::int64_t number) {
  require_run(number);
  sqlite::Statement row(connection, select_runs("WHERE run = ?"));
  if (!row.bind(number).step()) require_run(number);
  RunRecord run = run_of(row);
  run.sequences = sqlite::read_all<SequenceRecord>(connection, "sequences WHERE run = ? ORDER BY sequence", number);
  run.devices = sqlite::read_all<DeviceRecord>(connection, "devices WHERE run = ? ORDER BY position", number);
  sqlite::Statement extremes(connection,
                             "SELECT coalesce(min(min(from_psi, to_psi)), 0.0), coalesce(max(max(from_psi, to_psi)), "
                             "0.0) FROM branches WHERE run = ?");
  if (extremes.bind(number).step()) extremes.read(run.lowest_psi, run.highest_psi);
  return run;
}

std::vector<BranchRecord> RunStore::Database::branches(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(
      connection, fmt::format("SELECT branch, {} FROM branches WHERE run = ? ORDER BY branch", BranchRecord::kColumns));
  rows.bind(run);
  std::vector<BranchRecord> branches;
  while (rows.step()) {
    BranchRecord& b = branches.emplace_back();
    rows.read(b.branch, b.row());
  }
  return branches;
}

std::vector<EventRecord> RunStore::Database::events(std::int64_t run) {
  require_run(run);
  return sqlite::read_all<EventRecord>(connection, "events WHERE run = ? ORDER BY event", run);
}

namespace {

std::string select_checks(const std::string& rest) {
  return fmt::format("SELECT c.run, {} FROM checks c {}", CheckRecord::kColumns, rest);
}

CheckRecord check_of(const sqlite::Statement& row) {
  CheckRecord c;
  row.read(c.run, c.row());
  return c;
}

}  // namespace

std::vector<CheckRecord> RunStore::Database::checks(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(connection, select_checks("WHERE c.run = ? ORDER BY c.check_row"));
  rows.bind(run);
  std::vector<CheckRecord> checks;
  while (rows.step()) checks.push_back(check_of(rows));
  return checks;
}

std::vector<SeriesRecord> RunStore::Database::series(std::int64_t run) {
  require_run(run);
  return sqlite::read_all<SeriesRecord>(connection, "series WHERE run = ? ORDER BY sequence, taxel", run);
}

std::vector<SeriesRecord> RunStore::series(std::int64_t run) const { return database_->series(run); }
std::vector<CheckRecord> RunStore::checks(std::int64_t run) const { return database_->checks(run); }

std::optional<CheckRecord> RunStore::last_check(const std::string& sensor_serial, const std::string& kind,
                                                const std::string& verdict, std::int64_t before_run) const {
  sqlite::Statement rows(database_->connection,
                         select_checks("JOIN runs r ON r.run = c.run WHERE r.sensor_serial = ? AND c.kind = ? AND "
                                       "c.verdict = ? AND c.run < ? AND r.void_utc = '' "
                                       "ORDER BY c.check_row DESC LIMIT 1"));
  rows.bind(sensor_serial, kind, verdict, before_run);
  return rows.step() ? std::optional(check_of(rows)) : std::nullopt;
}

std::int64_t RunStore::last_time_ns(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT max(coalesce((SELECT max(time_ns) FROM events WHERE run = ?), 0),"
                        " coalesce((SELECT time_ns FROM frames WHERE frame > ? AND frame < ? "
                        "ORDER BY frame DESC LIMIT 1), 0))");
  return row.bind(run, frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

std::vector<RunRecord> RunStore::runs() const { return runs(RunFilter()); }

std::vector<RunRecord> RunStore::runs(const RunFilter& filter) const {
  std::string where;
  std::vector<std::string> values;
  for (const auto& [condition, value] :
       {std::pair("sensor_serial = ?", &filter.sensor_serial), std::pair("started_utc >= ?", &filter.since_utc),
        std::pair("content_sha256 = ?", &filter.content_sha256)}) {
    if (value->empty()) continue;
    where += fmt::format("{}{}", where.empty() ? " WHERE " : " AND ", condition);
    values.push_back(*value);
  }
  values.resize(3);
  sqlite::Statement rows(database_->connection, select_runs(where + " ORDER BY run"));
  const auto bound = [&](std::size_t i) { return values[i].empty() ? std::optional<std::string>() : values[i]; };
  rows.bind(bound(0), bound(1), bound(2));
  std::vector<RunRecord> runs;
  while (rows.step()) runs.push_back(run_of(rows));
  return runs;
}

RunRecord RunStore::run(std::int64_t number) const { return database_->run(number); }
std::vector<BranchRecord> RunStore::branches(std::int64_t run) const { return database_->branches(run); }
std::vector<EventRecord> RunStore::events(std::int64_t run) const { return database_->events(run); }

void RunStore::newest_events(std::int64_t run, const std::function<bool(const EventRecord&)>& see) const {
  sqlite::Statement rows(database_->connection,
                         fmt::format("SELECT {} FROM events WHERE run = ? ORDER BY event DESC", EventRecord::kColumns));
  rows.bind(run);
  EventRecord event;
  while (rows.step()) {
    rows.read(event.row());
    if (!see(event)) return;
  }
}

void RunStore::Database::require_frames(std::int64_t run) {
  require_run(run);
  sqlite::Statement row(connection, "SELECT rule, pruned_utc FROM pruned WHERE run = ?");
  if (!row.bind(run).step()) return;
  std::string rule, utc;
  row.read(rule, utc);
  throw StoreError(
      "TB-STORE-PRUNED",
      fmt::format("store {}: the frames of run {} were removed on {}, by the rule {}", path, run, utc, rule),
      "figures, models and verdicts are there (tactbench runs show); a simulated run can be repeated with its seeds, "
      "or use an earlier snapshot");
}

std::vector<FrameRecord> RunStore::frames(std::int64_t run) const {
  database_->require_frames(run);
  std::vector<FrameRecord> frames;
  frames.reserve(static_cast<std::size_t>(frame_count(run)));
  database_->for_each_frame(run, [&](const FrameRecord& frame) {
    if (!has_consistent_shape(frame)) {
      throw StoreError(
          "TB-STORE-SQL",
          fmt::format("store {}: frame {} of run {} holds {} counts, not those of scans x rows x columns {} x {} x {}",
                      path(), frames.size() + 1, run, frame.counts.size(), frame.scans, frame.rows, frame.columns),
          "another program changed the file: restore your last snapshot");
    }
    frames.push_back(frame);
  });
  return frames;
}

void RunStore::for_each_frame(std::int64_t run, const std::function<void(const FrameRecord&)>& see) const {
  database_->require_frames(run);
  database_->for_each_frame(run, see);
}

std::int64_t RunStore::frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection, "SELECT count(*) FROM frames WHERE frame > ? AND frame < ?");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

std::int64_t RunStore::void_frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(
      database_->connection,
      "SELECT count(*) FROM frames JOIN branches USING (branch) WHERE frame > ? AND frame < ? AND void");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

std::int64_t RunStore::flagged_frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection,
                        "SELECT count(*) FROM frames WHERE frame > ? AND frame < ? AND flags != ''");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

int RunStore::scans_of_first_frame(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection,
                        "SELECT scans FROM frames WHERE frame > ? AND frame < ? ORDER BY frame LIMIT 1");
  return row.bind(frames_above(run), frames_below(run)).first<int>().value_or(0);
}

// Records over time: figures, baselines, approved reports.

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
  check_nonblank_text("the baseline's reason", baseline.reason, kMaxTextLength);
  check_nonblank_text("the name of the person who accepts it", baseline.accepted_by, kMaxNameLength);
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
  const std::int64_t number = database_->insert_baseline(baseline, named);
  transaction.commit();
  return number;
}

std::vector<BaselineRecord> RunStore::baselines() const {
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

void RunStore::add_report(const ReportRecord& report) {
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
  seal(report.run, "approvals");
  transaction.commit();
}

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

std::vector<ReportRecord> RunStore::reports(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, select_reports("WHERE run = ? ORDER BY report_row"));
  rows.bind(run);
  return report_rows(rows);
}

std::vector<ReportRecord> RunStore::reports() const {
  sqlite::Statement rows(database_->connection, select_reports("ORDER BY report_row"));
  return report_rows(rows);
}

// Times of a run without reading the frames themselves, for time estimates.

std::vector<TimedSequence> RunStore::timed_sequences(const std::string& bench_id, int newest) const {
  sqlite::Statement rows(
      database_->connection,
      "SELECT r.run, r.overrides_json, s.sequence, s.recipe_sha256, s.repeats, s.frames_per_repeat "
      "FROM (SELECT run, overrides_json FROM runs WHERE outcome = 'completed' AND bench_id = ? AND void_utc = '' "
      "ORDER BY run DESC LIMIT ?) r JOIN sequences s ON s.run = r.run ORDER BY r.run DESC, s.sequence");
  rows.bind(bench_id, newest);
  std::vector<TimedSequence> found;
  while (rows.step()) {
    TimedSequence& s = found.emplace_back();
    rows.read(s.run, s.overrides_json, s.sequence, s.recipe_sha256, s.repeats, s.frames_per_repeat);
  }
  return found;
}

std::int64_t RunStore::last_position(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT frame FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1");
  const auto last = row.bind(frames_above(run), frames_below(run)).first<std::int64_t>();
  return last ? *last - frames_above(run) : 0;
}

std::optional<FrameTime> RunStore::frame_time(std::int64_t run, std::int64_t position) const {
  if (!database_->time_statement) {
    database_->time_statement =
        std::make_unique<sqlite::Statement>(database_->connection,
                                            "SELECT b.sequence, b.\"repeat\", f.ordinal, b.void, f.time_ns "
                                            "FROM frames f JOIN branches b ON b.branch = f.branch WHERE f.frame = ?");
  }
  sqlite::Statement& row = *database_->time_statement;
  std::optional<FrameTime> found;
  if (row.bind(frames_above(run) + position).step()) {
    FrameTime& time = found.emplace();
    row.read(time.sequence, time.repeat, time.ordinal, time.is_void, time.time_ns);
  }
  row.run();
  return found;
}

std::vector<TimedEvent> RunStore::timed_events(std::int64_t run) const {
  sqlite::Statement rows(database_->connection,
                         "SELECT time_ns, kind, detail FROM events WHERE run = ? AND kind IN ('state', 'way-back') "
                         "ORDER BY event");
  rows.bind(run);
  std::vector<TimedEvent> found;
  while (rows.step()) {
    TimedEvent& event = found.emplace_back();
    rows.read(event.time_ns, event.kind, event.detail);
  }
  return found;
}

}  // namespace tactbench::db
