#include "db/run_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "db/database.h"
#include "db/record.h"
#include "db/run_store.h"
#include "db/store_error.h"

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

std::string select_checks(const std::string& rest) {
  return fmt::format("SELECT c.run, {} FROM checks c {}", CheckRecord::kColumns, rest);
}

CheckRecord check_of(const sqlite::Statement& row) {
  CheckRecord c;
  row.read(c.run, c.row());
  return c;
}

void require_frames(Database& database, std::int64_t run) {
  database.require_run(run);
  sqlite::Statement row(database.connection, "SELECT rule, pruned_utc FROM pruned WHERE run = ?");
  if (!row.bind(run).step()) return;
  std::string rule, utc;
  row.read(rule, utc);
  throw StoreError(
      "TB-STORE-PRUNED",
      fmt::format("store {}: the frames of run {} were removed on {}, by the rule {}", database.path, run, utc, rule),
      "figures, models and verdicts are there (tactbench runs show); a simulated run can be repeated with its seeds, "
      "or use an earlier snapshot");
}

}  // namespace

const std::string& RunReader::path() const { return database_->path; }

std::optional<SensorRecord> RunReader::sensor(const std::string& serial) const {
  const auto found = sqlite::read_all<SensorRecord>(database_->connection, "sensors WHERE serial = ?", serial);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

std::vector<SensorRecord> RunReader::sensors() const {
  return sqlite::read_all<SensorRecord>(database_->connection, "sensors ORDER BY serial");
}

std::vector<RunRecord> RunReader::runs() const { return runs(RunFilter()); }

std::vector<RunRecord> RunReader::runs(const RunFilter& filter) const {
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

RunRecord RunReader::run(std::int64_t number) const {
  sqlite::Connection& connection = database_->connection;
  database_->require_run(number);
  sqlite::Statement row(connection, select_runs("WHERE run = ?"));
  if (!row.bind(number).step()) database_->require_run(number);
  RunRecord run = run_of(row);
  run.sequences = sqlite::read_all<SequenceRecord>(connection, "sequences WHERE run = ? ORDER BY sequence", number);
  run.devices = sqlite::read_all<DeviceRecord>(connection, "devices WHERE run = ? ORDER BY position", number);
  sqlite::Statement extremes(connection,
                             "SELECT coalesce(min(min(from_psi, to_psi)), 0.0), coalesce(max(max(from_psi, to_psi)), "
                             "0.0) FROM branches WHERE run = ?");
  if (extremes.bind(number).step()) extremes.read(run.lowest_psi, run.highest_psi);
  return run;
}

std::int64_t RunReader::run_of_uuid(const std::string& uuid) const {
  sqlite::Statement row(database_->connection, "SELECT run FROM runs WHERE uuid = ?");
  return row.bind(uuid).first<std::int64_t>().value_or(0);
}

std::vector<BranchRecord> RunReader::branches(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(
      database_->connection,
      fmt::format("SELECT branch, {} FROM branches WHERE run = ? ORDER BY branch", BranchRecord::kColumns));
  rows.bind(run);
  std::vector<BranchRecord> branches;
  while (rows.step()) {
    BranchRecord& b = branches.emplace_back();
    rows.read(b.branch, b.row());
  }
  return branches;
}

std::vector<FrameRecord> RunReader::frames(std::int64_t run) const {
  std::vector<FrameRecord> frames;
  frames.reserve(static_cast<std::size_t>(frame_count(run)));
  for_each_frame(run, [&](const FrameRecord& frame) {
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

void RunReader::for_each_frame(std::int64_t run, const std::function<void(const FrameRecord&)>& see) const {
  require_frames(*database_, run);
  sqlite::Statement rows(database_->connection,
                         fmt::format("SELECT {}, {} FROM frames WHERE frame > ? AND frame < ? ORDER BY frame",
                                     FrameRecord::kColumns, WrenchRecord::kColumns));
  rows.bind(frames_above(run), frames_below(run));
  FrameRecord f;
  while (rows.step()) {
    double target_n = 0.0;
    rows.read(f.row(), target_n);
    if (std::isnan(target_n)) {
      f.wrench.reset();
    } else {
      WrenchRecord& w = f.wrench.emplace();
      w.target_n = target_n;
      rows.read_from(std::tuple_size_v<decltype(f.row())> + 1, w.force_start_n, w.wrench, w.raw, w.place_mm);
    }
    see(f);
  }
}

std::int64_t RunReader::frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection, "SELECT count(*) FROM frames WHERE frame > ? AND frame < ?");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

std::int64_t RunReader::void_frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(
      database_->connection,
      "SELECT count(*) FROM frames JOIN branches USING (branch) WHERE frame > ? AND frame < ? AND void");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

std::int64_t RunReader::flagged_frame_count(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection,
                        "SELECT count(*) FROM frames WHERE frame > ? AND frame < ? AND flags != ''");
  return row.bind(frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

int RunReader::scans_of_first_frame(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement row(database_->connection,
                        "SELECT scans FROM frames WHERE frame > ? AND frame < ? ORDER BY frame LIMIT 1");
  return row.bind(frames_above(run), frames_below(run)).first<int>().value_or(0);
}

std::optional<PrunedRecord> RunReader::pruned(std::int64_t run) const {
  const auto found = sqlite::read_all<PrunedRecord>(database_->connection, "pruned WHERE run = ?", run);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

std::vector<EventRecord> RunReader::events(std::int64_t run) const {
  database_->require_run(run);
  return sqlite::read_all<EventRecord>(database_->connection, "events WHERE run = ? ORDER BY event", run);
}

void RunReader::newest_events(std::int64_t run, const std::function<bool(const EventRecord&)>& see) const {
  sqlite::Statement rows(database_->connection,
                         fmt::format("SELECT {} FROM events WHERE run = ? ORDER BY event DESC", EventRecord::kColumns));
  rows.bind(run);
  EventRecord event;
  while (rows.step()) {
    rows.read(event.row());
    if (!see(event)) return;
  }
}

std::vector<CheckRecord> RunReader::checks(std::int64_t run) const {
  database_->require_run(run);
  sqlite::Statement rows(database_->connection, select_checks("WHERE c.run = ? ORDER BY c.check_row"));
  rows.bind(run);
  std::vector<CheckRecord> checks;
  while (rows.step()) checks.push_back(check_of(rows));
  return checks;
}

std::vector<SeriesRecord> RunReader::series(std::int64_t run) const {
  database_->require_run(run);
  return sqlite::read_all<SeriesRecord>(database_->connection, "series WHERE run = ? ORDER BY sequence, taxel", run);
}

std::optional<CheckRecord> RunReader::last_check(const std::string& sensor_serial, const std::string& kind,
                                                 const std::string& verdict, std::int64_t before_run) const {
  sqlite::Statement rows(database_->connection,
                         select_checks("JOIN runs r ON r.run = c.run WHERE r.sensor_serial = ? AND c.kind = ? AND "
                                       "c.verdict = ? AND c.run < ? AND r.void_utc = '' "
                                       "ORDER BY c.check_row DESC LIMIT 1"));
  rows.bind(sensor_serial, kind, verdict, before_run);
  return rows.step() ? std::optional(check_of(rows)) : std::nullopt;
}

std::int64_t RunReader::last_time_ns(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT max(coalesce((SELECT max(time_ns) FROM events WHERE run = ?), 0),"
                        " coalesce((SELECT time_ns FROM frames WHERE frame > ? AND frame < ? "
                        "ORDER BY frame DESC LIMIT 1), 0))");
  return row.bind(run, frames_above(run), frames_below(run)).first<std::int64_t>().value();
}

// Times of a run without reading the frames themselves, for time estimates.

std::vector<TimedSequence> RunReader::timed_sequences(const std::string& bench_id, int newest) const {
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

std::int64_t RunReader::last_position(std::int64_t run) const {
  sqlite::Statement row(database_->connection,
                        "SELECT frame FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1");
  const auto last = row.bind(frames_above(run), frames_below(run)).first<std::int64_t>();
  return last ? *last - frames_above(run) : 0;
}

std::optional<FrameTime> RunReader::frame_time(std::int64_t run, std::int64_t position) const {
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

std::vector<TimedEvent> RunReader::timed_events(std::int64_t run) const {
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

// Integrity of the store: the chain of a run recomputed link by link, and SQLite's own checks of its file.

namespace {

// A text stored with its hash can be checked separately.
std::string text_that_changed(const RunRecord& run) {
  const auto changed = [](const std::string& text, const std::string& sha256) {
    return sha256.size() == 64 && sha256_hex(text) != sha256;
  };
  if (changed(run.bench_toml, run.bench_sha256)) return "the bench file kept with the run, or its hash";
  if (changed(run.sensor_toml, run.sensor_sha256)) return "the sensor file kept with the run, or its hash";
  for (const SequenceRecord& sequence : run.sequences) {
    if (!changed(sequence.recipe_toml, sequence.recipe_sha256)) continue;
    return fmt::format("the recipe of sequence {} ('{}') kept with the run, or its hash", sequence.sequence,
                       sequence.name);
  }
  return {};
}

// A frame's place in the run, as text for people.
std::string place_of(std::int64_t position, const RunRecord& run, const BranchRecord* branch, const FrameRecord& f) {
  if (branch == nullptr) return fmt::format("frame {} (of no branch of this run)", position);
  const auto sequence = std::ranges::find(run.sequences, branch->sequence, &SequenceRecord::sequence);
  return fmt::format("frame {} (sequence {} '{}', repeat {}, branch {}, attempt {}, step {})", position,
                     branch->sequence, sequence == run.sequences.end() ? "" : sequence->name, branch->repeat,
                     branch->ordinal, branch->attempt, f.ordinal);
}

// Where the frames were removed, the links kept in their place are checked against what is there.
void check_without_frames(ContentCheck& check, const RunRecord& run, const RunEnd& end, std::int64_t there,
                          HashChain& hasher) {
  const PrunedRecord& pruned = *check.pruned;
  check.frames = pruned.frames;
  check.computed_sha256 = hex(hasher.close(pruned.chain, pruned.frames, end));
  if (there > 0) {
    check.difference = fmt::format("{} frames are there although all were removed on {}", there, pruned.pruned_utc);
  } else if (hasher.header(run) != pruned.header) {
    const std::string text = text_that_changed(run);
    check.difference = text.empty() ? "the run's row, a sequence, a device, or the link kept of them" : text;
  } else if (check.computed_sha256 != check.stored_sha256) {
    check.difference =
        "an event, a branch, a check, a series, the outcome, its reason, the safe state, the link and number of frames "
        "kept of those that were removed, or the stored hash itself";
  }
}

}  // namespace

std::string RunReader::content_hash(std::int64_t number) const {
  HashChain& hasher = database_->hasher;
  const RunRecord run = this->run(number);
  const RunEnd end = end_of(*this, run);
  const std::vector<BranchRecord>& branches = end.branches;
  Digest chain = hasher.header(run);
  std::int64_t frames = 0;
  for_each_frame(number, [&](const FrameRecord& frame) {
    const auto branch = std::lower_bound(branches.begin(), branches.end(), frame.branch,
                                         [](const BranchRecord& b, std::int64_t key) { return b.branch < key; });
    // A frame without a branch of this run can only come from a manual change of the file; it still enters the hash.
    const bool known = branch != branches.end() && branch->branch == frame.branch;
    chain = hasher.frame(chain, known ? *branch : BranchRecord{}, frame);
    ++frames;
  });
  return hex(hasher.close(chain, frames, end));
}

ContentCheck RunReader::check_content(std::int64_t number) const {
  HashChain& hasher = database_->hasher;
  const RunRecord run = this->run(number);
  const RunEnd end = end_of(*this, run);

  ContentCheck check;
  check.stored_sha256 = run.content_sha256;
  check.pruned = pruned(number);
  if (check.pruned) {
    check_without_frames(check, run, end, frame_count(number), hasher);
    return check;
  }
  Digest chain = hasher.header(run);
  std::int64_t broken = 0;  // position of the first frame whose link differs from the stored one
  std::int64_t mended =
      0;  // of a later one whose link agrees: then only links were changed, not the rows that they cover
  std::string broken_place, gap;
  sqlite::Statement links(database_->connection,
                          "SELECT frame, chain FROM frames WHERE frame > ? AND frame < ? ORDER BY frame");
  links.bind(frames_above(number), frames_below(number));
  for_each_frame(number, [&](const FrameRecord& frame) {
    std::int64_t key = 0;
    Digest stored{};
    if (links.step()) links.read(key, stored);
    const auto branch = std::lower_bound(end.branches.begin(), end.branches.end(), frame.branch,
                                         [](const BranchRecord& b, std::int64_t id) { return b.branch < id; });
    const bool known = branch != end.branches.end() && branch->branch == frame.branch;
    chain = hasher.frame(chain, known ? *branch : BranchRecord{}, frame);
    const std::int64_t position = key - frames_above(number);
    ++check.frames;
    if (gap.empty() && broken == 0 && position != check.frames) {
      gap = fmt::format("frame {} is missing", check.frames);
    }
    if (chain == stored) {
      if (broken != 0 && mended == 0) mended = position;
    } else if (broken == 0) {
      broken = position;
      broken_place = place_of(position, run, known ? &*branch : nullptr, frame);
    }
  });
  check.computed_sha256 = hex(hasher.close(chain, check.frames, end));

  const bool ended = run.outcome != Outcome::kIncomplete;
  const bool same = ended ? check.computed_sha256 == check.stored_sha256 : check.stored_sha256.empty();
  if (!gap.empty()) {
    check.difference = gap;
  } else if (broken != 0 && (mended != 0 || (ended && same))) {
    check.difference = fmt::format("the link kept with {}; the frame itself is unchanged", broken_place);
  } else if (broken == 1) {
    const std::string text = text_that_changed(run);
    check.difference =
        text.empty() ? fmt::format("the run's row, a sequence, a device, or {} with its branch", broken_place) : text;
  } else if (broken != 0) {
    check.difference = fmt::format("{}: its row or its branch's place", broken_place);
  } else if (!same) {
    const std::string text = check.frames == 0 ? text_that_changed(run) : std::string();
    check.difference =
        !text.empty() ? text
                      : fmt::format(
                            "{}an event, a branch, a check, a series, the number of frames (now {}), the "
                            "outcome, its reason, the safe state, or the stored hash itself",
                            check.frames == 0 ? "the run's row, a sequence, a device, "
                                              : "everything up to the last frame is unchanged; what follows is not:  ",
                            check.frames);
  }
  return check;
}

std::vector<std::string> RunReader::check_seals(std::int64_t run) const {
  std::vector<std::string> wrong;
  for (const char* kind : kSealed) {
    const Seal now = database_->seal_now(run, kind);
    Seal stored;
    sqlite::Statement row(database_->connection, "SELECT count, sha256 FROM seals WHERE run = ? AND kind = ?");
    const bool there = row.bind(run, kind).step();
    if (there) row.read(stored.count, stored.sha256);
    if (!there) {
      wrong.push_back(
          fmt::format("{}: the count and hash of what was stored are missing; {} there now", kind, now.count));
    } else if (stored.count != now.count) {
      wrong.push_back(fmt::format("{}: {} were stored, {} there now", kind, stored.count, now.count));
    } else if (stored.sha256 != now.sha256 && !(stored.count == 0 && stored.sha256.empty())) {
      wrong.push_back(fmt::format("{}: changed since they were stored", kind));
    }
  }
  return wrong;
}

std::vector<std::string> RunReader::check_structure() const {
  std::vector<std::string> wrong;
  {
    sqlite::Statement rows(database_->connection, "PRAGMA integrity_check");
    while (rows.step()) {
      if (const auto line = rows.value<std::string>(); line != "ok") wrong.push_back(line);
    }
  }
  for (ForeignObjects found = foreign_objects(database_->connection);
       const auto* lines : {&found.changed, &found.added})
    wrong.insert(wrong.end(), lines->begin(), lines->end());
  for (const char* table : {"runs", "baselines", "nights"}) {
    const std::int64_t there = database_->connection.integer(fmt::format("SELECT count(*) FROM {}", table));
    const std::int64_t made = database_->connection.integer(
        fmt::format("SELECT coalesce((SELECT max(seq) FROM sqlite_sequence WHERE name = '{}'), 0)", table));
    if (there < made)
      wrong.push_back(
          fmt::format("{}: {} were stored but {} are there, although none is ever deleted", table, made, there));
  }
  sqlite::Statement rows(database_->connection,
                         "SELECT \"table\", rowid, parent FROM pragma_foreign_key_check ORDER BY 1, 2 LIMIT 100");
  while (rows.step()) {
    wrong.push_back(fmt::format("row {} of {} names a row of {} that is not there", rows.value<std::int64_t>(1),
                                rows.value<std::string>(0), rows.value<std::string>(2)));
  }
  return wrong;
}

namespace {

constexpr const char* kColumns =
    "SELECT f.frame, f.time_ns, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.\"rows\", f.columns, f.scans, "
    "f.counts, f.flags, coalesce(b.void, 0), f.wrench IS NOT NULL, f.target_n, f.force_start_n, f.wrench, f.place_mm "
    "FROM frames f LEFT JOIN branches b ON b.branch = f.branch WHERE f.frame > ? AND f.frame < ? ORDER BY f.frame ";

StoredFrame frame_of(const sqlite::Statement& row, std::int64_t above, const std::string& path) {
  StoredFrame seen;
  FrameRecord shape;
  row.read(seen.position, seen.time_ns, seen.setpoint_psi, seen.feedback_psi, seen.reference_psi, shape.rows,
           shape.columns, shape.scans, shape.counts, seen.flags, seen.is_void);
  if (!has_consistent_shape(shape)) {
    throw StoreError("TB-STORE-SQL",
                     fmt::format("store {}: frame {} does not hold scans x rows x columns counts", path, seen.position),
                     "another program changed the file: restore your last snapshot");
  }
  seen.position -= above;
  seen.rows = shape.rows;
  seen.columns = shape.columns;
  seen.scans = shape.scans;
  seen.counts = std::move(shape.counts);
  if (row.value<bool>(11)) {
    WrenchRecord& wrench = seen.wrench.emplace();
    row.read_from(12, wrench.target_n, wrench.force_start_n, wrench.wrench, wrench.place_mm);
  }
  return seen;
}

struct ResetAtEnd {
  sqlite::Statement& statement;
  ~ResetAtEnd() { statement.reset(); }
};

}  // namespace

std::vector<double> mean_counts(const StoredFrame& frame) {
  return scan_means(frame.counts, static_cast<std::size_t>(frame.scans));
}

struct RunFrameReader::Queries {
  explicit Queries(const RunReader& store)
      : connection(std::filesystem::absolute(store.path()).string(), sqlite::Access::kReadOnly) {
    connection.disable_triggers_and_views();
  }
  sqlite::Connection connection;
  sqlite::Statement after{connection, std::string(kColumns) + "LIMIT ?"};  // asked for at every frame
};

RunFrameReader::RunFrameReader(const RunReader& store, std::int64_t run)
    : run_(run), queries_(std::make_unique<Queries>(store)) {}
RunFrameReader::RunFrameReader(RunFrameReader&&) noexcept = default;
RunFrameReader& RunFrameReader::operator=(RunFrameReader&&) noexcept = default;
RunFrameReader::~RunFrameReader() = default;

void RunFrameReader::frames_after(std::int64_t position, int most, const std::function<void(const StoredFrame&)>& see) {
  const std::int64_t above = frames_above(run_);
  sqlite::Statement& rows = queries_->after;
  const ResetAtEnd reset{rows};  // otherwise the writer's log could not be moved into the file
  rows.bind(above + std::max<std::int64_t>(position, 0), frames_below(run_), most);
  while (rows.step()) see(frame_of(rows, above, queries_->connection.path()));
}

std::optional<StoredFrame> RunFrameReader::newest() {
  const std::int64_t above = frames_above(run_);
  sqlite::Statement row(queries_->connection, std::string(kColumns) + "DESC LIMIT 1");
  if (!row.bind(above, frames_below(run_)).step()) return std::nullopt;
  return frame_of(row, above, queries_->connection.path());
}

std::int64_t RunFrameReader::before_newest(int most) {
  sqlite::Statement row(queries_->connection,
                        "SELECT frame FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1 OFFSET ?");
  const auto frame = row.bind(frames_above(run_), frames_below(run_), most).first<std::int64_t>();
  return frame ? *frame - frames_above(run_) : 0;
}

}  // namespace tactbench::db
