#include "db/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "db/run_store.h"

namespace tactbench::db {

namespace {

// Several queries of one state of the file.
class Snapshot {
 public:
  explicit Snapshot(sqlite::Connection& connection) : connection_(connection), own_(!connection.in_transaction()) {
    if (own_) connection_.execute("BEGIN");
  }
  ~Snapshot() {
    try {
      if (own_ && connection_.in_transaction()) connection_.execute("ROLLBACK");
    } catch (const StoreError&) {  // nothing was changed
    }
  }
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  sqlite::Connection& connection_;
  bool own_;
};

struct SchemaObject {
  std::string type, table, sql;
  bool operator==(const SchemaObject&) const = default;
};
using SchemaObjects = std::map<std::pair<std::string, std::string>, SchemaObject>;  // by name and kind

// Skips the tables of ANALYZE: they hold statistics, and only SQLite itself can make tables with such names.
SchemaObjects objects_of(sqlite::Connection& connection) {
  sqlite::Statement rows(connection,
                         "SELECT type, name, tbl_name, coalesce(sql, '') FROM main.sqlite_master "
                         "WHERE NOT (type = 'table' AND name GLOB 'sqlite_stat[134]') ORDER BY name, type");
  SchemaObjects objects;
  while (rows.step()) {
    SchemaObject object;
    std::string name;
    rows.read(object.type, name, object.table, object.sql);
    objects[{name, object.type}] = object;
  }
  return objects;
}

SchemaObjects objects_after(const Migrations& migrations) {
  sqlite::Connection fresh(":memory:", sqlite::Access::kReadWrite);
  for (const std::string& sql : migrations) fresh.execute(sql);
  return objects_of(fresh);
}

SchemaObjects objects_of_version(const Migrations& known, std::int64_t version) {
  static const SchemaObjects own = objects_after(builtin_migrations());  // asked for whenever a store is opened
  if (&known == &builtin_migrations() && version == kSchemaVersion) return own;
  return objects_after({known.begin(), known.begin() + std::min<std::int64_t>(version, std::ssize(known))});
}

[[noreturn]] void refuse_other_schema(const std::string& path, const std::string& difference) {
  throw StoreError("TB-STORE-OTHER-SCHEMA",
                   fmt::format("store {} is not of this program's schema: {}", path, difference),
                   "read it with the build of tactbench that wrote it (its runs state version and commit), or repeat "
                   "its runs; if somebody changed the file, restore your last snapshot");
}

}  // namespace

const Migrations& builtin_migrations() {
  static const Migrations own = {schema_1()};
  return own;
}

void check_version(sqlite::Connection& connection, const Migrations& known) {
  const Snapshot snapshot(connection);
  const std::int64_t version = connection.integer("PRAGMA user_version");
  if (version > std::ssize(known))
    refuse_other_schema(connection.path(),
                        fmt::format("it has schema {}, this program knows schemas up to {}", version, known.size()));
  const auto damaged = [&](const std::string& what) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: the file is damaged: {}", connection.path(), what),
                     kDamagedRemedy);
  };
  const std::int64_t pages = connection.integer("PRAGMA page_count");
  if (version < 0 || (version == 0 && connection.integer("SELECT count(*) FROM sqlite_master") > 0))
    damaged(fmt::format("its header names schema version {}, which no tactbench wrote", version));
  // With a log the count is the log's, and a file that was to become shorter may still have its old length.
  std::error_code unknown;
  const std::uintmax_t logged = std::filesystem::file_size(connection.path() + "-wal", unknown);
  if (!unknown && logged > 0) return;
  const std::uintmax_t bytes = std::filesystem::file_size(connection.path(), unknown);
  if (unknown || static_cast<std::int64_t>(bytes) <= pages * std::int64_t{kPageSize}) return;
  damaged(fmt::format("its header states {} pages, and it has {} bytes", pages, bytes));
}

ForeignObjects foreign_objects(sqlite::Connection& connection, const Migrations& known) {
  const Snapshot snapshot(connection);  // another process may migrate meanwhile
  const SchemaObjects ours = objects_of_version(known, connection.integer("PRAGMA user_version"));
  const SchemaObjects there = objects_of(connection);
  ForeignObjects found;
  for (const auto& [key, object] : ours) {
    const auto& [name, type] = key;
    const auto own = there.find(key);
    if (own == there.end())
      found.changed.push_back(fmt::format("{} '{}' is missing", type, name));
    else if (own->second != object)
      found.changed.push_back(fmt::format("{} '{}' differs from that of tactbench", type, name));
  }
  for (const auto& [key, object] : there) {
    if (ours.contains(key)) continue;
    const auto& [name, type] = key;
    // A view in place of a table is more than an addition.
    const auto first = ours.lower_bound({name, ""});
    const bool disguised = first != ours.end() && first->first.first == name;
    (disguised ? found.changed : found.added)
        .push_back(fmt::format("{} '{}'{} does not belong to tactbench", type, name,
                               type == "trigger" || type == "index" ? fmt::format(" on '{}'", object.table) : ""));
  }
  return found;
}

void refuse_foreign(sqlite::Connection& connection, Additions additions, const Migrations& known) {
  const ForeignObjects found = foreign_objects(connection, known);
  const auto listed = [](std::vector<std::string> lines) {
    constexpr std::size_t kShown = 5;
    const std::size_t more = lines.size() - std::min(lines.size(), kShown);
    lines.resize(lines.size() - more);
    return fmt::format("{}{}", fmt::join(lines, "; "), more > 0 ? fmt::format("; and {} more", more) : "");
  };
  if (!found.changed.empty()) refuse_other_schema(connection.path(), listed(found.changed));
  if (additions == Additions::kTolerate || found.added.empty()) return;
  throw StoreError(
      "TB-STORE-FOREIGN", fmt::format("store {}: {}", connection.path(), listed(found.added)),
      "a store must not contain other tables, indexes, views or triggers: drop them, or restore your last snapshot; "
      "keep your own in another file that attaches a copy of the store (sqlite3 own.db \"ATTACH 'copy.db' AS runs\")");
}

void migrate(sqlite::Connection& connection, const Migrations& known) {
  const auto last = static_cast<std::int64_t>(known.size());
  if (connection.integer("PRAGMA user_version") == last) return;
  sqlite::Transaction transaction(connection);
  check_version(connection, known);  // another process may have migrated it meanwhile
  for (std::int64_t version = connection.integer("PRAGMA user_version"); version < last; ++version)
    connection.execute(known.at(static_cast<std::size_t>(version)));
  connection.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, last));
  transaction.commit();
}

// Schema 1: the tables, indexes and views of a store. Changed in place until a version is released, then never again.

namespace {

// A REAL that may be NULL: NULL means "not a number": no reading.
constexpr const char* kTables = R"sql(
CREATE TABLE sensors (
  serial TEXT PRIMARY KEY NOT NULL CHECK (serial <> ''),
  type TEXT NOT NULL, type_toml TEXT NOT NULL, type_sha256 TEXT NOT NULL,
  scanner_serial TEXT NOT NULL, note TEXT NOT NULL, added_utc TEXT NOT NULL
) STRICT;

CREATE TABLE runs (
  run INTEGER PRIMARY KEY AUTOINCREMENT,
  uuid TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('simulated', 'hardware', 'imported')),
  state TEXT NOT NULL CHECK (state <> ''),
  outcome TEXT NOT NULL CHECK (outcome IN ('incomplete', 'completed', 'stopped', 'aborted', 'failed', 'interrupted')),
  reason TEXT NOT NULL,
  safe_state TEXT NOT NULL CHECK (safe_state IN ('unknown', 'verified', 'unverified', 'failed')),
  operator TEXT NOT NULL, purpose TEXT NOT NULL,
  sensor_serial TEXT REFERENCES sensors (serial), scanner_serial TEXT NOT NULL,
  bench_id TEXT NOT NULL, bench_toml TEXT NOT NULL, bench_sha256 TEXT NOT NULL,
  sensor_toml TEXT NOT NULL, sensor_sha256 TEXT NOT NULL, overrides_json TEXT NOT NULL,
  program_version TEXT NOT NULL, git_commit TEXT NOT NULL,
  git_dirty INTEGER NOT NULL CHECK (git_dirty IN (0, 1)),
  build_id TEXT NOT NULL, host TEXT NOT NULL, time_zone TEXT NOT NULL,
  seed INTEGER NOT NULL, sensor_seed INTEGER NOT NULL,
  started_utc TEXT NOT NULL, ended_utc TEXT NOT NULL, content_sha256 TEXT NOT NULL,
  seen_utc TEXT NOT NULL DEFAULT '',         -- when the run's process was last known to live
  rest_s REAL,                               -- between the sensor's last load and this run, by the wall clock
  tags TEXT NOT NULL DEFAULT '', notes TEXT NOT NULL DEFAULT '',
  void_reason TEXT NOT NULL DEFAULT '',      -- a void run counts no more and is kept
  void_by TEXT NOT NULL DEFAULT '',
  void_utc TEXT NOT NULL DEFAULT '',         -- '': the run counts
  CHECK ((state = 'ended') = (outcome <> 'incomplete')),
  CHECK ((void_utc = '') = (void_reason = '') AND (void_utc = '') = (void_by = ''))
) STRICT;

CREATE TABLE sequences (
  run INTEGER NOT NULL REFERENCES runs (run),
  sequence INTEGER NOT NULL CHECK (sequence >= 0),
  name TEXT NOT NULL, recipe_toml TEXT NOT NULL, recipe_sha256 TEXT NOT NULL,
  repeats INTEGER NOT NULL, frames_per_repeat INTEGER NOT NULL,
  PRIMARY KEY (run, sequence)
) STRICT;

CREATE TABLE devices (
  run INTEGER NOT NULL REFERENCES runs (run),
  position INTEGER NOT NULL,
  role TEXT NOT NULL, model TEXT NOT NULL, serial TEXT NOT NULL, firmware TEXT NOT NULL,
  origin TEXT NOT NULL, calibration_json TEXT NOT NULL,
  PRIMARY KEY (run, position)
) STRICT;

CREATE TABLE branches (
  branch INTEGER PRIMARY KEY,
  run INTEGER NOT NULL, sequence INTEGER NOT NULL,
  "repeat" INTEGER NOT NULL CHECK ("repeat" >= 0),
  ordinal INTEGER NOT NULL CHECK (ordinal >= 0),
  attempt INTEGER NOT NULL CHECK (attempt >= 0),
  void INTEGER NOT NULL CHECK (void IN (0, 1)), void_reason TEXT NOT NULL,
  from_psi REAL NOT NULL, to_psi REAL NOT NULL,
  from_n REAL, to_n REAL,  -- of a branch of force; its pressures are 0
  UNIQUE (run, sequence, "repeat", ordinal, attempt),
  FOREIGN KEY (run, sequence) REFERENCES sequences (run, sequence)
) STRICT;

CREATE TABLE frames (
  frame INTEGER PRIMARY KEY CHECK (frame % 1000000000 > 0),  -- run * 1000000000 + position in the run, from 1
  branch INTEGER NOT NULL REFERENCES branches (branch),
  ordinal INTEGER NOT NULL,
  setpoint_psi REAL NOT NULL, feedback_psi REAL, reference_psi REAL,
  setpoint_counts INTEGER NOT NULL, feedback_counts INTEGER NOT NULL, reference_counts INTEGER NOT NULL,
  time_ns INTEGER NOT NULL, since_command_ns INTEGER NOT NULL, in_band_ns INTEGER NOT NULL,
  device_time_us INTEGER NOT NULL, status INTEGER NOT NULL, exchanges INTEGER NOT NULL,
  dtype TEXT NOT NULL CHECK (dtype = 'uint16le'),
  "rows" INTEGER NOT NULL CHECK ("rows" > 0), columns INTEGER NOT NULL CHECK (columns > 0),
  scans INTEGER NOT NULL CHECK (scans > 0),
  counts BLOB NOT NULL CHECK (length(counts) = 2 * "rows" * columns * scans),  -- scan slowest, then row, then column
  chain BLOB NOT NULL CHECK (length(chain) = 32),  -- SHA-256 of the chain up to this frame
  flags TEXT NOT NULL DEFAULT '',  -- what makes it incomparable: 'dwell', 'left-band', ...
  trace BLOB NOT NULL DEFAULT x''  -- float32le, 4 a poll since the frame before: seconds before this frame,
    CHECK (length(trace) % 16 = 0),  -- set-point, feedback, reference psi
  target_n REAL, force_start_n REAL,  -- the force at the dwell's start; the wrench is at frame time
  wrench BLOB CHECK (length(wrench) = 48),          -- float64le: Fx Fy Fz N, Tx Ty Tz N mm
  wrench_raw BLOB CHECK (length(wrench_raw) = 48),  -- as it came: counts or volts
  place_mm BLOB CHECK (length(place_mm) = 24)       -- float64le: x, y, z of the stage
) STRICT;

CREATE TABLE events (
  event INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  time_ns INTEGER NOT NULL, kind TEXT NOT NULL, id TEXT NOT NULL, detail TEXT NOT NULL
) STRICT;
CREATE INDEX events_of_run ON events (run);

-- The document is the whole fit; model, stands and fitted are taken from it for those who search. Its numbers are text,
-- which brings every double back: a REAL holds neither -0.0 nor NaN.
CREATE TABLE fits (
  fit INTEGER PRIMARY KEY AUTOINCREMENT,
  run INTEGER NOT NULL REFERENCES runs (run),
  model TEXT NOT NULL,  -- with its options: 'elam', 'elam, free run'
  stands INTEGER NOT NULL CHECK (stands IN (0, 1)),  -- for its run, where no fit is named
  fitted INTEGER NOT NULL CHECK (fitted >= 0),       -- taxels
  document TEXT NOT NULL,                            -- JSON "tactbench.model"
  made_by TEXT NOT NULL,                             -- build and class of processor, for who recomputes it
  program_version TEXT NOT NULL, created_utc TEXT NOT NULL
) STRICT;
CREATE INDEX fits_of_run ON fits (run);

CREATE TABLE verdicts (
  verdict_row INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  fit INTEGER REFERENCES fits (fit),  -- NULL: judged without a stored fit
  criterion TEXT NOT NULL,
  scope_kind TEXT NOT NULL CHECK (scope_kind IN ('array', 'level', 'span')),
  low_psi REAL NOT NULL, high_psi REAL NOT NULL,  -- of a level equal, of the array 0
  direction TEXT NOT NULL CHECK (direction IN ('both', 'up', 'down')),
  taxel_share REAL NOT NULL,                         -- of the taxels, that the figure is to hold for
  value REAL, expanded REAL, limit_value REAL,       -- expanded: U of the value; NULL: not known
  unit TEXT NOT NULL CHECK (unit IN ('psi', 'FS', 'taxels')),  -- of value, expanded and limit_value
  rule TEXT NOT NULL,
  verdict TEXT NOT NULL
    CHECK (verdict IN ('pass', 'conditional pass', 'conditional fail', 'fail', 'inconclusive')),
  limits_toml TEXT NOT NULL, limits_sha256 TEXT NOT NULL
) STRICT;
CREATE INDEX verdicts_of_run ON verdicts (run);

CREATE TABLE checks (
  check_row INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  time_ns INTEGER NOT NULL,
  kind TEXT NOT NULL CHECK (kind <> ''),  -- seating | warm-up | conditioning | mount | tare
  verdict TEXT NOT NULL CHECK (verdict IN ('pass', 'fail', 'warning')),
  detail_json TEXT NOT NULL,
  data BLOB NOT NULL  -- float64le, what the kind says
) STRICT;
CREATE INDEX checks_of_run ON checks (run, kind);

-- Imported runs: tables of other programs, at full precision.
CREATE TABLE series (
  run INTEGER NOT NULL,
  sequence INTEGER NOT NULL,
  taxel INTEGER NOT NULL CHECK (taxel >= 0),
  input BLOB NOT NULL,  -- float64le, in the order of the table's rows
  output BLOB NOT NULL CHECK (length(output) = length(input) AND length(input) % 8 = 0),
  PRIMARY KEY (run, sequence, taxel),
  FOREIGN KEY (run, sequence) REFERENCES sequences (run, sequence)
) STRICT;

-- Records over time: figures of runs, baselines that people accepted, reports that people signed.
CREATE TABLE figures (
  run INTEGER NOT NULL REFERENCES runs (run),
  subject TEXT NOT NULL CHECK (subject <> ''),  -- what the figures are of: 'nightly/paper', 'sensor', 'rig'
  name TEXT NOT NULL CHECK (name <> ''),        -- with the unit in it
  value REAL,
  PRIMARY KEY (run, subject, name)
) STRICT;
CREATE INDEX figures_of_subject ON figures (subject, name, run);

CREATE TABLE baselines (
  baseline INTEGER PRIMARY KEY AUTOINCREMENT,  -- of one subject; the newest is the one that counts
  subject TEXT NOT NULL CHECK (subject <> ''),
  reason TEXT NOT NULL CHECK (reason <> ''), accepted_by TEXT NOT NULL CHECK (accepted_by <> ''),
  accepted_utc TEXT NOT NULL
) STRICT;
CREATE TABLE baseline_runs (
  baseline INTEGER NOT NULL REFERENCES baselines (baseline),
  run INTEGER NOT NULL REFERENCES runs (run),
  PRIMARY KEY (baseline, run)
) STRICT;

CREATE TABLE reports (
  report_row INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  number TEXT NOT NULL, content_sha256 TEXT NOT NULL,
  approved_by TEXT NOT NULL CHECK (approved_by <> ''), approved_utc TEXT NOT NULL,
  replaces TEXT NOT NULL,          -- number of the report approved before it; '': none
  reason TEXT NOT NULL,            -- why it replaces that one
  evidence TEXT NOT NULL,          -- the runs that it rests on: number here when signed, content hash; one a line
  UNIQUE (run, number)
) STRICT;

-- Models, verdicts, approvals and voids are covered by hashes, as the content is, so that a deletion or change of them
-- is detected.
CREATE TABLE seals (
  run INTEGER NOT NULL REFERENCES runs (run),
  kind TEXT NOT NULL CHECK (kind <> ''),  -- fits | verdicts | approvals | void; each run has them all
  count INTEGER NOT NULL CHECK (count >= 0),
  sha256 TEXT NOT NULL,                   -- of the rows; '' until there is one
  PRIMARY KEY (run, kind)
) STRICT;

-- Nights with the results of their scenarios, and runs whose frames were removed.
CREATE TABLE nights (
  night INTEGER PRIMARY KEY AUTOINCREMENT,
  suite TEXT NOT NULL CHECK (suite <> ''), suite_file TEXT NOT NULL, suite_toml TEXT NOT NULL,
  selection_json TEXT NOT NULL,  -- which scenarios and seeds of the suite
  shard INTEGER NOT NULL CHECK (shard >= 1),
  shards INTEGER NOT NULL CHECK (shards >= shard),  -- 1: the whole night
  begun_utc TEXT NOT NULL, ended_utc TEXT NOT NULL, program TEXT NOT NULL
) STRICT;

CREATE TABLE night_results (
  night INTEGER NOT NULL REFERENCES nights (night),
  position INTEGER NOT NULL CHECK (position >= 0),  -- in the whole suite with its seeds
  label TEXT NOT NULL CHECK (label <> ''),
  first_run INTEGER REFERENCES runs (run),          -- NULL: the scenario made none
  result_json TEXT NOT NULL,                        -- as measured, before it was compared with other nights
  PRIMARY KEY (night, position)
) STRICT;

CREATE TABLE pruned (
  run INTEGER PRIMARY KEY REFERENCES runs (run),
  frames INTEGER NOT NULL CHECK (frames > 0), bytes INTEGER NOT NULL,
  header BLOB NOT NULL CHECK (length(header) = 32),  -- first link of the run's hash chain
  chain BLOB NOT NULL CHECK (length(chain) = 32),    -- its link of the last frame, with which the rest is checked
  frames_sha256 TEXT NOT NULL,                       -- of the frames alone, for comparison with other nights
  rule TEXT NOT NULL CHECK (rule <> ''), pruned_utc TEXT NOT NULL CHECK (pruned_utc <> '')
) STRICT;

-- So that what a verb shows is found without reading all runs and frames.
CREATE INDEX runs_of_seeds ON runs (seed, sensor_seed);
CREATE INDEX runs_of_sensor ON runs (sensor_serial);
CREATE INDEX runs_by_start ON runs (started_utc);
CREATE INDEX runs_of_content ON runs (content_sha256);
CREATE INDEX runs_open ON runs (run) WHERE state <> 'ended';
CREATE INDEX verdicts_of_fit ON verdicts (fit);
)sql";

constexpr const char* kViews = R"sql(
CREATE VIEW v_runs AS
SELECT r.run, r.uuid, r.origin, r.state, r.outcome, r.reason, r.safe_state, r.operator, r.purpose, r.sensor_serial,
  r.scanner_serial, r.bench_id,
  (SELECT group_concat(name, ', ') FROM (SELECT name FROM sequences s WHERE s.run = r.run ORDER BY sequence)) AS recipes,
  coalesce((SELECT max(f.frame) FROM frames f  -- they are numbered from 1
    WHERE f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999) - r.run * 1000000000, 0) AS frames,
  coalesce(p.frames, 0) AS frames_pruned, coalesce(p.pruned_utc, '') AS pruned_utc,
  r.program_version, r.git_commit, r.git_dirty, r.seed, r.sensor_seed, r.started_utc, r.ended_utc, r.rest_s,
  r.content_sha256, r.tags, r.notes, r.void_utc <> '' AS void, r.void_reason, r.void_by, r.void_utc
FROM runs r LEFT JOIN pruned p ON p.run = r.run;

CREATE VIEW v_nights AS
SELECT n.night, n.suite, n.shard, n.shards, n.begun_utc, n.ended_utc, n.program, s.position, s.label, s.first_run,
  s.result_json
FROM nights n JOIN night_results s ON s.night = n.night;

CREATE VIEW v_events AS
SELECT run, time_ns * 1e-9 AS time_s, kind, id, detail FROM events ORDER BY event;

CREATE VIEW v_checks AS
SELECT run, time_ns * 1e-9 AS time_s, kind, verdict, detail_json FROM checks ORDER BY check_row;

CREATE VIEW v_devices AS
SELECT run, role, model, serial, firmware, origin, calibration_json FROM devices ORDER BY run, position;

CREATE VIEW v_fit_taxels AS
SELECT f.run, f.fit, f.model, json_extract(t.value, '$.taxel') AS taxel, json_extract(t.value, '$.status') AS status,
  json_extract(t.value, '$.noise') AS noise, json_extract(t.value, '$.figures.j') AS j,
  json_extract(t.value, '$.figures.mean_error') AS mean_error,
  json_extract(t.value, '$.figures.max_error') AS max_error,
  json_extract(t.value, '$.figures.full_scale') AS full_scale, json_extract(f.document, '$.output.unit') AS unit,
  json_extract(t.value, '$.at_bound') AS at_bound
FROM fits f, json_each(f.document, '$.taxels') t;

CREATE VIEW v_verdicts AS
SELECT v.run, v.fit, r.origin, r.sensor_serial, v.criterion, v.scope_kind, v.low_psi, v.high_psi, v.direction,
  v.taxel_share, v.value, v.expanded, v.limit_value, v.unit, v.rule, v.verdict, v.limits_sha256
FROM verdicts v JOIN runs r ON r.run = v.run;

CREATE VIEW v_figures AS
SELECT f.run, r.origin, r.sensor_serial, r.started_utc, f.subject, f.name, f.value, r.void_utc <> '' AS void
FROM figures f JOIN runs r ON r.run = f.run;
)sql";

// SQL for number `index` of a blob of float64le, exact, and NULL where it is not finite; SQLite has no function for it.
// Of the hexadecimal digits (two a byte, lowest byte first) the last two bytes, `top`, hold sign, exponent and the
// mantissa's highest four bits, the six before them, `low`, its other bits (IEEE 754, binary64). The mantissa is a
// whole number below 2^53; powers of two that scale it are whole numbers up to 2^62, three of which reach 2^-186. Below
// that it counts as 0.
std::string number_of(const std::string& blob, int index) {
  const auto digit = [](int position) {  // value of the digit at `position`, from 1
    return fmt::format("(instr('0123456789ABCDEF', substr(h, {}, 1)) - 1)", position);
  };
  const auto byte = [&](int number) {
    return fmt::format("({} * 16 + {})", digit(2 * number + 1), digit(2 * number + 2));
  };
  std::string low;
  for (int i = 0; i < 6; ++i) low += fmt::format("{}({} << {})", i == 0 ? "" : " | ", byte(i), 8 * i);
  return fmt::format(
      "(SELECT CASE WHEN (top >> 4) & 2047 = 0 THEN 0.0 WHEN (top >> 4) & 2047 < 2047 THEN (1 - (top >> 15) * 2) * "
      "((16 | (top & 15)) << 48 | low) * 1.0 "
      "/ (1 << min(max(1075 - ((top >> 4) & 2047), 0), 62)) / (1 << min(max(1013 - ((top >> 4) & 2047), 0), 62)) "
      "/ (1 << min(max(951 - ((top >> 4) & 2047), 0), 62)) * (1 << min(max(((top >> 4) & 2047) - 1075, 0), 62)) END "
      "FROM (SELECT {} << 8 | {} AS top, {} AS low FROM (SELECT hex(substr({}, {}, 8)) AS h)) WHERE {} IS NOT NULL)",
      byte(7), byte(6), low, blob, 8 * index + 1, blob);
}

// With the raw counts, the wrench and the place, the latter two also as numbers.
std::string frames_view() {
  std::string numbers;
  const char* const wrench[] = {"fx_n", "fy_n", "fz_n", "tx_nmm", "ty_nmm", "tz_nmm"};
  const char* const place[] = {"x_mm", "y_mm", "z_mm"};
  for (int i = 0; const char* name : wrench) numbers += fmt::format(",\n  {} AS {}", number_of("f.wrench", i++), name);
  for (int i = 0; const char* name : place) numbers += fmt::format(",\n  {} AS {}", number_of("f.place_mm", i++), name);
  return fmt::format(R"sql(
CREATE VIEW v_frames AS
SELECT r.run, f.frame - r.run * 1000000000 AS position, s.name AS recipe, b.sequence, b."repeat", b.ordinal AS branch,
  b.attempt, b.void, b.from_psi, b.to_psi, b.from_n, b.to_n, f.ordinal AS step, f.setpoint_psi,
  f.feedback_psi, f.reference_psi, f.target_n, f.force_start_n, f.setpoint_counts, f.feedback_counts, f.reference_counts,
  f.time_ns, f.time_ns * 1e-9 AS time_s, f.since_command_ns, f.in_band_ns, f.flags, f.device_time_us, f.status,
  f.exchanges, f.dtype, f."rows", f.columns, f.scans, f.counts,
  (SELECT CASE WHEN instr(d.calibration_json, '"volts_per_count":') > 0 THEN nullif(CAST(substr(d.calibration_json,
    instr(d.calibration_json, '"volts_per_count":') + 18) AS REAL), 0.0) END  -- where trusted_schema is off, JSON's functions are refused
    FROM devices d WHERE d.run = r.run AND d.role = 'tactile scanner' ORDER BY d.position LIMIT 1) AS volts_per_count{},
  f.wrench_raw, length(f.trace) / 16 AS polls, lower(hex(f.chain)) AS chain_sha256
FROM runs r
JOIN frames f ON f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999
JOIN branches b ON b.branch = f.branch
JOIN sequences s ON s.run = b.run AND s.sequence = b.sequence;
)sql",
                     numbers);
}

}  // namespace

std::string schema_1() { return kTables + frames_view() + kViews; }

}  // namespace tactbench::db
