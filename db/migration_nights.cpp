// Schema 8: nights with the results of their scenarios, and runs whose frames were removed.
#include "db/schema.h"

namespace tactbench::db {

namespace {

constexpr const char* kNights = R"sql(
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

DROP VIEW v_runs;
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
)sql";

}  // namespace

std::string nights_migration() { return kNights; }

}  // namespace tactbench::db
