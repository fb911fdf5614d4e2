// The SQL of the migrations. From the first release on none is edited: a change is a new one.
#include <array>
#include <cstddef>

#include "db/run_store.h"
#include "db/schema.h"

namespace tactbench::db {

namespace {

// A REAL that may be NULL: NULL stands for "not a number", that is, no reading.
constexpr const char* kVersion1 = R"sql(
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
  tags TEXT NOT NULL DEFAULT '', notes TEXT NOT NULL DEFAULT '',
  CHECK ((state = 'ended') = (outcome <> 'incomplete'))
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
  chain BLOB NOT NULL CHECK (length(chain) = 32)  -- SHA-256 of the chain up to this frame
) STRICT;

CREATE TABLE events (
  event INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  time_ns INTEGER NOT NULL, kind TEXT NOT NULL, id TEXT NOT NULL, detail TEXT NOT NULL
) STRICT;
CREATE INDEX events_of_run ON events (run);

CREATE TABLE fits (
  fit INTEGER PRIMARY KEY AUTOINCREMENT,
  run INTEGER NOT NULL REFERENCES runs (run),
  model TEXT NOT NULL, options_json TEXT NOT NULL, summary_json TEXT NOT NULL,
  program_version TEXT NOT NULL, created_utc TEXT NOT NULL, patterns_json TEXT NOT NULL
) STRICT;
CREATE INDEX fits_of_run ON fits (run, model);

CREATE TABLE fit_taxels (
  fit INTEGER NOT NULL REFERENCES fits (fit),
  taxel INTEGER NOT NULL,  -- row * columns + column; -1: the mean taxel
  status TEXT NOT NULL,
  parameters BLOB NOT NULL, ascending_v BLOB NOT NULL, descending_v BLOB NOT NULL,  -- float64le
  noise_v REAL, j_v2 REAL, mean_error_v REAL, max_error_v REAL, full_scale_v REAL,
  at_bound INTEGER NOT NULL,
  PRIMARY KEY (fit, taxel)
) STRICT;

CREATE TABLE verdicts (
  verdict_row INTEGER PRIMARY KEY,
  run INTEGER NOT NULL REFERENCES runs (run),
  fit INTEGER REFERENCES fits (fit),  -- NULL: judged without a stored fit
  criterion TEXT NOT NULL, scope TEXT NOT NULL, value REAL, limit_value REAL,
  unit TEXT NOT NULL,  -- of value and limit_value
  rule TEXT NOT NULL,
  verdict TEXT NOT NULL
    CHECK (verdict IN ('pass', 'conditional pass', 'conditional fail', 'fail', 'inconclusive')),
  limits_toml TEXT NOT NULL, limits_sha256 TEXT NOT NULL
) STRICT;
CREATE INDEX verdicts_of_run ON verdicts (run);

CREATE VIEW v_runs AS
SELECT r.run, r.uuid, r.origin, r.state, r.outcome, r.reason, r.safe_state, r.operator, r.purpose, r.sensor_serial,
  r.scanner_serial, r.bench_id,
  (SELECT group_concat(name, ', ') FROM (SELECT name FROM sequences s WHERE s.run = r.run ORDER BY sequence)) AS recipes,
  (SELECT count(*) FROM frames f
    WHERE f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999) AS frames,
  r.program_version, r.git_commit, r.git_dirty, r.seed, r.sensor_seed, r.started_utc, r.ended_utc, r.content_sha256,
  r.tags, r.notes
FROM runs r;

CREATE VIEW v_frames AS
SELECT r.run, f.frame - r.run * 1000000000 AS position, s.name AS recipe, b.sequence, b."repeat", b.ordinal AS branch,
  b.attempt, b.void, b.from_psi, b.to_psi, f.ordinal AS step, f.setpoint_psi, f.feedback_psi, f.reference_psi,
  f.setpoint_counts, f.feedback_counts, f.reference_counts, f.time_ns, f.time_ns * 1e-9 AS time_s, f.since_command_ns,
  f.in_band_ns, f.device_time_us, f.status, f.exchanges, f.dtype, f."rows", f.columns, f.scans,
  lower(hex(f.chain)) AS chain_sha256
FROM runs r
JOIN frames f ON f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999
JOIN branches b ON b.branch = f.branch
JOIN sequences s ON s.run = b.run AND s.sequence = b.sequence;

CREATE VIEW v_verdicts AS
SELECT v.run, v.fit, r.origin, r.sensor_serial, v.criterion, v.scope, v.value, v.limit_value, v.unit, v.rule, v.verdict,
  v.limits_sha256
FROM verdicts v JOIN runs r ON r.run = v.run;
)sql";

// Columns for a sequencer that pauses, redoes and presses: dwells that deviate, the fast trace, the wrench.
constexpr const char* kVersion2 = R"sql(
ALTER TABLE runs ADD COLUMN seen_utc TEXT NOT NULL DEFAULT '';  -- when the run's process was last known to live
ALTER TABLE runs ADD COLUMN rest_s REAL;  -- between the sensor's last load and this run, by the wall clock

ALTER TABLE branches ADD COLUMN from_n REAL;  -- of a branch of force; its pressures are 0
ALTER TABLE branches ADD COLUMN to_n REAL;

ALTER TABLE frames ADD COLUMN flags TEXT NOT NULL DEFAULT '';  -- what makes it incomparable: 'dwell', 'left-band', ...
ALTER TABLE frames ADD COLUMN trace BLOB NOT NULL DEFAULT x''  -- float32le, 4 a poll since the frame before: seconds
  CHECK (length(trace) % 16 = 0);                              -- before this frame, set-point, feedback, reference psi
ALTER TABLE frames ADD COLUMN target_n REAL;
ALTER TABLE frames ADD COLUMN force_start_n REAL;              -- at the dwell's start; the wrench is at frame time
ALTER TABLE frames ADD COLUMN wrench BLOB CHECK (length(wrench) = 48);      -- float64le: Fx Fy Fz N, Tx Ty Tz N mm
ALTER TABLE frames ADD COLUMN wrench_raw BLOB CHECK (length(wrench_raw) = 48);  -- as it came: counts or volts
ALTER TABLE frames ADD COLUMN place_mm BLOB CHECK (length(place_mm) = 24);  -- float64le: x, y, z of the stage

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

DROP VIEW v_frames;
CREATE VIEW v_frames AS
SELECT r.run, f.frame - r.run * 1000000000 AS position, s.name AS recipe, b.sequence, b."repeat", b.ordinal AS branch,
  b.attempt, b.void, b.from_psi, b.to_psi, b.from_n, b.to_n, f.ordinal AS step, f.setpoint_psi,
  f.feedback_psi, f.reference_psi, f.target_n, f.setpoint_counts, f.feedback_counts, f.reference_counts, f.time_ns,
  f.time_ns * 1e-9 AS time_s, f.since_command_ns, f.in_band_ns, f.flags, f.device_time_us, f.status, f.exchanges,
  f.dtype, f."rows", f.columns, f.scans, length(f.trace) / 16 AS polls, lower(hex(f.chain)) AS chain_sha256
FROM runs r
JOIN frames f ON f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999
JOIN branches b ON b.branch = f.branch
JOIN sequences s ON s.run = b.run AND s.sequence = b.sequence;
)sql";

// Imported runs: tables of other programs, at full precision.
constexpr const char* kVersion3 = R"sql(
CREATE TABLE series (
  run INTEGER NOT NULL,
  sequence INTEGER NOT NULL,
  taxel INTEGER NOT NULL CHECK (taxel >= 0),
  input BLOB NOT NULL,  -- float64le, in the order of the table's rows
  output BLOB NOT NULL CHECK (length(output) = length(input) AND length(input) % 8 = 0),
  PRIMARY KEY (run, sequence, taxel),
  FOREIGN KEY (run, sequence) REFERENCES sequences (run, sequence)
) STRICT;
)sql";

// People's remarks on a run (tags and notes were there from the first version), and views for readers with SQL.
constexpr const char* kVersion4 = R"sql(
ALTER TABLE runs ADD COLUMN void_reason TEXT NOT NULL DEFAULT '';  -- a void run counts no more and is kept
ALTER TABLE runs ADD COLUMN void_by TEXT NOT NULL DEFAULT '';
ALTER TABLE runs ADD COLUMN void_utc TEXT NOT NULL DEFAULT ''      -- '': the run counts
  CHECK ((void_utc = '') = (void_reason = '') AND (void_utc = '') = (void_by = ''));

DROP VIEW v_runs;
CREATE VIEW v_runs AS
SELECT r.run, r.uuid, r.origin, r.state, r.outcome, r.reason, r.safe_state, r.operator, r.purpose, r.sensor_serial,
  r.scanner_serial, r.bench_id,
  (SELECT group_concat(name, ', ') FROM (SELECT name FROM sequences s WHERE s.run = r.run ORDER BY sequence)) AS recipes,
  (SELECT count(*) FROM frames f
    WHERE f.frame BETWEEN r.run * 1000000000 + 1 AND r.run * 1000000000 + 999999999) AS frames,
  r.program_version, r.git_commit, r.git_dirty, r.seed, r.sensor_seed, r.started_utc, r.ended_utc, r.rest_s,
  r.content_sha256, r.tags, r.notes, r.void_utc <> '' AS void, r.void_reason, r.void_by, r.void_utc
FROM runs r;

CREATE VIEW v_events AS
SELECT run, time_ns * 1e-9 AS time_s, kind, id, detail FROM events ORDER BY event;

CREATE VIEW v_checks AS
SELECT run, time_ns * 1e-9 AS time_s, kind, verdict, detail_json FROM checks ORDER BY check_row;

CREATE VIEW v_devices AS
SELECT run, role, model, serial, firmware, origin, calibration_json FROM devices ORDER BY run, position;

CREATE VIEW v_fit_taxels AS
SELECT f.run, f.fit, f.model, t.taxel, t.status, t.noise_v, t.j_v2, t.mean_error_v, t.max_error_v, t.full_scale_v,
  t.at_bound
FROM fits f JOIN fit_taxels t ON t.fit = f.fit;
)sql";

// Records over time: figures of runs, baselines that people accepted, reports that people signed.
constexpr const char* kVersion5 = R"sql(
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
  replaces TEXT NOT NULL,  -- number of the report approved before it; '': none
  UNIQUE (run, number)
) STRICT;

CREATE VIEW v_figures AS
SELECT f.run, r.origin, r.sensor_serial, r.started_utc, f.subject, f.name, f.value, r.void_utc <> '' AS void
FROM figures f JOIN runs r ON r.run = f.run;
)sql";

// Models, verdicts, approvals and voids are covered by hashes, as the content is, so that a deletion or change of them
// is detected.
constexpr const char* kVersion6 = R"sql(
CREATE TABLE seals (
  run INTEGER NOT NULL REFERENCES runs (run),
  kind TEXT NOT NULL CHECK (kind <> ''),        -- fits | verdicts | approvals | void; each run has them all
  count INTEGER NOT NULL CHECK (count >= 0),
  sha256 TEXT NOT NULL,                         -- of the rows; '': not hashed, nothing was written since schema 6
  PRIMARY KEY (run, kind)
) STRICT;
INSERT INTO seals SELECT r.run, 'fits', (SELECT count(*) FROM fits f WHERE f.run = r.run), '' FROM runs r;
INSERT INTO seals SELECT r.run, 'verdicts', (SELECT count(*) FROM verdicts v WHERE v.run = r.run), '' FROM runs r;
INSERT INTO seals SELECT r.run, 'approvals', (SELECT count(*) FROM reports p WHERE p.run = r.run), '' FROM runs r;
INSERT INTO seals SELECT run, 'void', void_utc <> '', '' FROM runs;
)sql";

constexpr std::array kMigrations = {kVersion1, kVersion2, kVersion3, kVersion4, kVersion5, kVersion6};
constexpr std::array kFurther = {frames_view_migration, nights_migration, report_reasons_migration};
static_assert(kMigrations.size() + kFurther.size() == kSchemaVersion);

}  // namespace

std::string migration(std::int64_t version) {
  const auto index = static_cast<std::size_t>(version);
  return index < kMigrations.size() ? kMigrations[index] : kFurther.at(index - kMigrations.size())();
}

}  // namespace tactbench::db
