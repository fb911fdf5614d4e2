// Reading runs back.
#include <fmt/format.h>

#include <sstream>

#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

constexpr const char* kRunColumns =
    "SELECT run, uuid, origin, state, outcome, reason, safe_state, operator, purpose, sensor_serial, scanner_serial, "
    "bench_id, bench_toml, bench_sha256, sensor_toml, sensor_sha256, overrides_json, program_version, git_commit, "
    "git_dirty, build_id, host, time_zone, seed, sensor_seed, started_utc, ended_utc, content_sha256, seen_utc, "
    "rest_s, "
    "tags, notes, void_reason, void_by, void_utc FROM runs";

RunRecord run_of(const sqlite::Statement& row) {
  RunRecord r;
  std::string outcome, safe_state, tags;
  row.read(r.run, r.uuid, r.origin, r.state, outcome, r.reason, safe_state, r.operator_name, r.purpose, r.sensor_serial,
           r.scanner_serial, r.bench_id, r.bench_toml, r.bench_sha256, r.sensor_toml, r.sensor_sha256, r.overrides_json,
           r.program_version, r.git_commit, r.git_dirty, r.build_id, r.host, r.time_zone, r.seed, r.sensor_seed,
           r.started_utc, r.ended_utc, r.content_sha256, r.seen_utc, r.rest_s, tags, r.notes, r.void_reason, r.void_by,
           r.void_utc);
  std::istringstream words(tags);
  for (std::string tag; words >> tag;) r.tags.push_back(tag);
  const auto known_outcome = outcome_from(outcome);
  const auto known_state = safe_state_from(safe_state);
  if (!known_outcome || !known_state) {
    throw StoreError("TB-STORE-SQL",
                     fmt::format("run {} has the outcome '{}' and the safe state '{}'", r.run, outcome, safe_state),
                     "the file was changed by another hand: take your last snapshot");
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
  sqlite::Statement row(connection, std::string(kRunColumns) + " WHERE run = ?");
  if (!row.bind(number).step()) require_run(number);
  RunRecord run = run_of(row);
  sqlite::Statement sequences(connection,
                              "SELECT sequence, name, recipe_toml, recipe_sha256, repeats, frames_per_repeat "
                              "FROM sequences WHERE run = ? ORDER BY sequence");
  sequences.bind(number);
  while (sequences.step()) {
    SequenceRecord& s = run.sequences.emplace_back();
    sequences.read(s.sequence, s.name, s.recipe_toml, s.recipe_sha256, s.repeats, s.frames_per_repeat);
  }
  sqlite::Statement devices(connection,
                            "SELECT role, model, serial, firmware, origin, calibration_json "
                            "FROM devices WHERE run = ? ORDER BY position");
  devices.bind(number);
  while (devices.step()) {
    DeviceRecord& d = run.devices.emplace_back();
    devices.read(d.role, d.model, d.serial, d.firmware, d.origin, d.calibration_json);
  }
  sqlite::Statement extremes(connection,
                             "SELECT coalesce(min(min(from_psi, to_psi)), 0.0), coalesce(max(max(from_psi, to_psi)), "
                             "0.0) FROM branches WHERE run = ?");
  if (extremes.bind(number).step()) extremes.read(run.lowest_psi, run.highest_psi);
  return run;
}

std::vector<BranchRecord> RunStore::Database::branches(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(connection,
                         "SELECT branch, sequence, \"repeat\", ordinal, attempt, void, void_reason, from_psi, to_psi, "
                         "from_n, to_n FROM branches WHERE run = ? ORDER BY branch");
  rows.bind(run);
  std::vector<BranchRecord> branches;
  while (rows.step()) {
    BranchRecord& b = branches.emplace_back();
    rows.read(b.branch, b.sequence, b.repeat, b.ordinal, b.attempt, b.is_void, b.void_reason, b.from_psi, b.to_psi,
              b.from_n, b.to_n);
  }
  return branches;
}

std::vector<EventRecord> RunStore::Database::events(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(connection, "SELECT time_ns, kind, id, detail FROM events WHERE run = ? ORDER BY event");
  rows.bind(run);
  std::vector<EventRecord> events;
  while (rows.step()) {
    EventRecord& event = events.emplace_back();
    rows.read(event.time_ns, event.kind, event.id, event.detail);
  }
  return events;
}

namespace {

constexpr const char* kCheckColumns = "SELECT c.run, c.time_ns, c.kind, c.verdict, c.detail_json, c.data FROM checks c";

CheckRecord check_of(const sqlite::Statement& row) {
  CheckRecord c;
  row.read(c.run, c.time_ns, c.kind, c.verdict, c.detail_json, c.data);
  return c;
}

}  // namespace

std::vector<CheckRecord> RunStore::Database::checks(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(connection, std::string(kCheckColumns) + " WHERE c.run = ? ORDER BY c.check_row");
  rows.bind(run);
  std::vector<CheckRecord> checks;
  while (rows.step()) checks.push_back(check_of(rows));
  return checks;
}

std::vector<SeriesRecord> RunStore::Database::series(std::int64_t run) {
  require_run(run);
  sqlite::Statement rows(connection,
                         "SELECT sequence, taxel, input, output FROM series WHERE run = ? ORDER BY sequence, taxel");
  rows.bind(run);
  std::vector<SeriesRecord> series;
  while (rows.step()) {
    SeriesRecord& s = series.emplace_back();
    rows.read(s.sequence, s.taxel, s.input, s.output);
  }
  return series;
}

std::vector<SeriesRecord> RunStore::series(std::int64_t run) const { return database_->series(run); }
std::vector<CheckRecord> RunStore::checks(std::int64_t run) const { return database_->checks(run); }

std::optional<CheckRecord> RunStore::last_check(const std::string& sensor_serial, const std::string& kind,
                                                const std::string& verdict, std::int64_t before_run) const {
  sqlite::Statement rows(database_->connection,
                         std::string(kCheckColumns) +
                             " JOIN runs r ON r.run = c.run WHERE r.sensor_serial = ? AND c.kind = ? AND "
                             "c.verdict = ? AND c.run < ? AND r.void_utc = '' ORDER BY c.check_row DESC LIMIT 1");
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
  sqlite::Statement rows(database_->connection, std::string(kRunColumns) + where + " ORDER BY run");
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
                         "SELECT time_ns, kind, id, detail FROM events WHERE run = ? ORDER BY event DESC");
  rows.bind(run);
  EventRecord event;
  while (rows.step()) {
    rows.read(event.time_ns, event.kind, event.id, event.detail);
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
      "figures, models and verdicts are there (tactbench runs show); a simulated run can be carried out "
      "again with its seeds, or take a snapshot from before");
}

std::vector<FrameRecord> RunStore::frames(std::int64_t run) const {
  database_->require_frames(run);
  std::vector<FrameRecord> frames;
  frames.reserve(static_cast<std::size_t>(frame_count(run)));
  database_->each_frame(run, [&](const FrameRecord& frame) {
    if (!fits_its_shape(frame)) {
      throw StoreError(
          "TB-STORE-SQL",
          fmt::format("store {}: frame {} of run {} holds {} counts, not those of scans x rows x columns {} x {} x {}",
                      path(), frames.size() + 1, run, frame.counts.size(), frame.scans, frame.rows, frame.columns),
          "the file was changed by another hand: take your last snapshot");
    }
    frames.push_back(frame);
  });
  return frames;
}

void RunStore::each_frame(std::int64_t run, const std::function<void(const FrameRecord&)>& see) const {
  database_->require_frames(run);
  database_->each_frame(run, see);
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

}  // namespace tactbench::db
