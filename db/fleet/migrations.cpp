#include "db/fleet/migrations.h"

#include <fmt/format.h>

#include <array>

namespace tactbench::db::fleet {

namespace {

// Nothing is ever changed or deleted, by nobody: what people remark later on a run is a further row of revisions. The
// triggers hold for the owner, too; dropping old partitions of frames remains possible to who owns them.
constexpr const char* kVersion1 = R"sql(
CREATE SCHEMA fleet;

CREATE TABLE fleet.about (fleet text NOT NULL DEFAULT gen_random_uuid()::text);
INSERT INTO fleet.about DEFAULT VALUES;
CREATE TABLE fleet.migrations (
  version bigint PRIMARY KEY, program_version text NOT NULL, applied_at timestamptz NOT NULL DEFAULT now()
);

-- As registered on a bench; two benches may know a serial with other types.
CREATE TABLE fleet.sensors (
  serial text NOT NULL CHECK (serial <> ''), type text NOT NULL, type_toml text NOT NULL, type_sha256 text NOT NULL,
  scanner_serial text NOT NULL, note text NOT NULL, added_utc text NOT NULL,
  PRIMARY KEY (serial, type_sha256, scanner_serial)
);

-- A run as it ended. One that was resumed and ended again is a further row with the same uuid.
CREATE TABLE fleet.runs (
  run bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  uuid text NOT NULL CHECK (length(uuid) = 36),
  origin text NOT NULL CHECK (origin IN ('simulated', 'hardware', 'imported')),
  state text NOT NULL CHECK (state = 'ended'),
  outcome text NOT NULL CHECK (outcome IN ('completed', 'stopped', 'aborted', 'failed', 'interrupted')),
  reason text NOT NULL, safe_state text NOT NULL, operator text NOT NULL, purpose text NOT NULL,
  sensor_serial text, scanner_serial text NOT NULL,
  bench_id text NOT NULL, bench_toml text NOT NULL, bench_sha256 text NOT NULL,
  sensor_toml text NOT NULL, sensor_sha256 text NOT NULL, overrides_json text NOT NULL,
  program_version text NOT NULL, git_commit text NOT NULL, git_dirty bigint NOT NULL, build_id text NOT NULL,
  host text NOT NULL, time_zone text NOT NULL, seed bigint NOT NULL, sensor_seed bigint NOT NULL,
  started_utc text NOT NULL, ended_utc text NOT NULL,
  content_sha256 text NOT NULL CHECK (length(content_sha256) = 64),
  seen_utc text NOT NULL, rest_s double precision,
  sensor_type_sha256 text, sensor_scanner text,  -- the registration in fleet.sensors
  frames bigint NOT NULL CHECK (frames >= 0),
  month bigint NOT NULL,                         -- of the start, 202601; 0: not known. Frames are partitioned by it
  pushed_by text NOT NULL DEFAULT session_user, pushed_at timestamptz NOT NULL DEFAULT now(),
  UNIQUE (uuid, content_sha256),
  FOREIGN KEY (sensor_serial, sensor_type_sha256, sensor_scanner) REFERENCES fleet.sensors
);
CREATE INDEX runs_of_sensor ON fleet.runs (sensor_serial, started_utc);
CREATE INDEX runs_of_bench ON fleet.runs (bench_id, started_utc);

CREATE TABLE fleet.sequences (
  run bigint NOT NULL REFERENCES fleet.runs, sequence bigint NOT NULL, name text NOT NULL, recipe_toml text NOT NULL,
  recipe_sha256 text NOT NULL, repeats bigint NOT NULL, frames_per_repeat bigint NOT NULL,
  PRIMARY KEY (run, sequence)
);
CREATE TABLE fleet.devices (
  run bigint NOT NULL REFERENCES fleet.runs, position bigint NOT NULL, role text NOT NULL, model text NOT NULL,
  serial text NOT NULL, firmware text NOT NULL, origin text NOT NULL, calibration_json text NOT NULL,
  PRIMARY KEY (run, position)
);
CREATE TABLE fleet.branches (
  run bigint NOT NULL REFERENCES fleet.runs, position bigint NOT NULL, sequence bigint NOT NULL,
  repeat bigint NOT NULL, ordinal bigint NOT NULL, attempt bigint NOT NULL, void bigint NOT NULL,
  void_reason text NOT NULL, from_psi double precision NOT NULL, to_psi double precision NOT NULL,
  from_n double precision, to_n double precision,
  PRIMARY KEY (run, position)
);
CREATE TABLE fleet.events (
  run bigint NOT NULL REFERENCES fleet.runs, position bigint NOT NULL, time_ns bigint NOT NULL, kind text NOT NULL,
  id text NOT NULL, detail text NOT NULL,
  PRIMARY KEY (run, position)
);
CREATE TABLE fleet.checks (
  run bigint NOT NULL REFERENCES fleet.runs, position bigint NOT NULL, time_ns bigint NOT NULL, kind text NOT NULL,
  verdict text NOT NULL, detail_json text NOT NULL, data bytea NOT NULL,
  PRIMARY KEY (run, position)
);
CREATE TABLE fleet.series (
  run bigint NOT NULL REFERENCES fleet.runs, sequence bigint NOT NULL, taxel bigint NOT NULL, input bytea NOT NULL,
  output bytea NOT NULL,
  PRIMARY KEY (run, sequence, taxel)
);

-- No foreign key: a frame is stored with its run in one transaction, and checking it a frame would cost half the time.
CREATE TABLE fleet.frames (
  run bigint NOT NULL, month bigint NOT NULL, position bigint NOT NULL,
  branch bigint NOT NULL,                        -- its position in fleet.branches
  ordinal bigint NOT NULL, setpoint_psi double precision NOT NULL, feedback_psi double precision,
  reference_psi double precision, setpoint_counts bigint NOT NULL, feedback_counts bigint NOT NULL,
  reference_counts bigint NOT NULL, time_ns bigint NOT NULL, since_command_ns bigint NOT NULL,
  in_band_ns bigint NOT NULL, device_time_us bigint NOT NULL, status bigint NOT NULL, exchanges bigint NOT NULL,
  dtype text NOT NULL, rows bigint NOT NULL, columns bigint NOT NULL, scans bigint NOT NULL,
  counts bytea NOT NULL,                         -- uint16, little-endian: scans x rows x columns
  chain bytea NOT NULL, flags text NOT NULL, trace bytea NOT NULL, target_n double precision,
  force_start_n double precision, wrench bytea, wrench_raw bytea, place_mm bytea,
  PRIMARY KEY (month, run, position)
) PARTITION BY LIST (month);
ALTER TABLE fleet.frames ALTER COLUMN counts SET STORAGE EXTERNAL, ALTER COLUMN trace SET STORAGE EXTERNAL;

CREATE TABLE fleet.fits (
  fit bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  run bigint NOT NULL REFERENCES fleet.runs,
  sha256 text NOT NULL CHECK (length(sha256) = 64),  -- of the fit and its taxels
  copy bigint NOT NULL,                              -- 0, or counted where a store has the same fit more than once
  parent_sha256 text NOT NULL DEFAULT '',            -- of the fit that this one replaces; '': made on a bench
  model text NOT NULL, options_json text NOT NULL, summary_json text NOT NULL, program_version text NOT NULL,
  created_utc text NOT NULL, patterns_json text NOT NULL,
  pushed_by text NOT NULL DEFAULT session_user, pushed_at timestamptz NOT NULL DEFAULT now(),
  UNIQUE (run, sha256, copy)
);
CREATE TABLE fleet.fit_taxels (
  fit bigint NOT NULL REFERENCES fleet.fits, taxel bigint NOT NULL, status text NOT NULL, parameters bytea NOT NULL,
  ascending_v bytea NOT NULL, descending_v bytea NOT NULL, noise_v double precision, j_v2 double precision,
  mean_error_v double precision, max_error_v double precision, full_scale_v double precision, at_bound bigint NOT NULL,
  PRIMARY KEY (fit, taxel)
);

-- What people and analyses say of a run after its end, whole, as one store had it; of a run the newest one counts.
CREATE TABLE fleet.revisions (
  revision bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  run bigint NOT NULL REFERENCES fleet.runs,
  source text NOT NULL,       -- the store: host and file
  fingerprint text NOT NULL,  -- by which that store knows what it pushed
  sha256 text NOT NULL CHECK (length(sha256) = 64),
  tags text NOT NULL, notes text NOT NULL, void_reason text NOT NULL, void_by text NOT NULL, void_utc text NOT NULL,
  pushed_by text NOT NULL DEFAULT session_user, pushed_at timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX revisions_of_run ON fleet.revisions (run, revision);
CREATE TABLE fleet.verdicts (
  revision bigint NOT NULL REFERENCES fleet.revisions, position bigint NOT NULL,
  fit_uuid text NOT NULL, fit_sha256 text NOT NULL,  -- the models: uuid of their run and fits.sha256; '': none stored
  criterion text NOT NULL, scope text NOT NULL, value double precision, limit_value double precision,
  unit text NOT NULL, rule text NOT NULL, verdict text NOT NULL, limits_toml text NOT NULL, limits_sha256 text NOT NULL,
  PRIMARY KEY (revision, position)
);
CREATE TABLE fleet.figures (
  revision bigint NOT NULL REFERENCES fleet.revisions, subject text NOT NULL, name text NOT NULL,
  value double precision,
  PRIMARY KEY (revision, subject, name)
);
CREATE TABLE fleet.reports (
  revision bigint NOT NULL REFERENCES fleet.revisions, position bigint NOT NULL, number text NOT NULL,
  content_sha256 text NOT NULL, approved_by text NOT NULL, approved_utc text NOT NULL, replaces text NOT NULL,
  PRIMARY KEY (revision, position)
);

CREATE TABLE fleet.baselines (
  baseline bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  sha256 text NOT NULL UNIQUE, subject text NOT NULL, reason text NOT NULL, accepted_by text NOT NULL,
  accepted_utc text NOT NULL,
  pushed_by text NOT NULL DEFAULT session_user, pushed_at timestamptz NOT NULL DEFAULT now()
);
CREATE TABLE fleet.baseline_runs (
  baseline bigint NOT NULL REFERENCES fleet.baselines, uuid text NOT NULL,
  PRIMARY KEY (baseline, uuid)
);

-- The newest row of each uuid, with its newest remarks.
CREATE VIEW fleet.every_run AS
SELECT DISTINCT ON (r.uuid) r.run, r.uuid, r.origin, r.outcome, r.reason, r.safe_state, r.operator, r.purpose,
  r.sensor_serial, s.type AS sensor_type, r.scanner_serial, r.bench_id,
  (SELECT string_agg(q.name, ', ' ORDER BY q.sequence) FROM fleet.sequences q WHERE q.run = r.run) AS recipes,
  r.frames, r.program_version, r.git_commit, r.git_dirty <> 0 AS git_dirty, r.seed, r.sensor_seed, r.started_utc,
  r.ended_utc, r.rest_s, r.content_sha256, r.month, coalesce(v.tags, '') AS tags, coalesce(v.notes, '') AS notes,
  coalesce(v.void_utc, '') <> '' AS void, coalesce(v.void_reason, '') AS void_reason,
  coalesce(v.void_by, '') AS void_by, coalesce(v.void_utc, '') AS void_utc, v.revision, v.source, r.host,
  r.pushed_by, r.pushed_at
FROM fleet.runs r
LEFT JOIN fleet.sensors s ON s.serial = r.sensor_serial AND s.type_sha256 = r.sensor_type_sha256
  AND s.scanner_serial = r.sensor_scanner
LEFT JOIN LATERAL (SELECT * FROM fleet.revisions n WHERE n.run = r.run ORDER BY n.revision DESC LIMIT 1) v ON true
ORDER BY r.uuid, r.ended_utc DESC, r.run DESC;

-- For readers with SQL: one set of views for each origin, since origins never mix.
DO $views$
DECLARE origin text;
BEGIN
  FOREACH origin IN ARRAY ARRAY['hardware', 'simulated', 'imported'] LOOP
    EXECUTE format('CREATE VIEW fleet.%s_runs AS SELECT * FROM fleet.every_run WHERE origin = %L', origin, origin);
    EXECUTE format('CREATE VIEW fleet.%s_frames AS SELECT r.uuid, q.name AS recipe, b.sequence, b.repeat, '
      'b.ordinal AS branch_ordinal, b.attempt, b.void, b.from_psi, b.to_psi, b.from_n, b.to_n, f.* FROM fleet.%s_runs r '
      'JOIN fleet.frames f ON f.month = r.month AND f.run = r.run '
      'JOIN fleet.branches b ON b.run = f.run AND b.position = f.branch '
      'JOIN fleet.sequences q ON q.run = b.run AND q.sequence = b.sequence', origin, origin);
    EXECUTE format('CREATE VIEW fleet.%s_fits AS SELECT r.uuid, r.sensor_serial, f.* FROM fleet.%s_runs r '
      'JOIN fleet.fits f ON f.run = r.run', origin, origin);
    EXECUTE format('CREATE VIEW fleet.%s_verdicts AS SELECT r.run, r.uuid, r.sensor_serial, r.void, v.* '
      'FROM fleet.%s_runs r JOIN fleet.verdicts v ON v.revision = r.revision', origin, origin);
    EXECUTE format('CREATE VIEW fleet.%s_figures AS SELECT r.run, r.uuid, r.sensor_serial, r.bench_id, r.started_utc, '
      'r.void, f.subject, f.name, f.value FROM fleet.%s_runs r JOIN fleet.figures f ON f.revision = r.revision',
      origin, origin);
    EXECUTE format('CREATE VIEW fleet.%s_events AS SELECT r.uuid, e.* FROM fleet.%s_runs r '
      'JOIN fleet.events e ON e.run = r.run', origin, origin);
  END LOOP;
END $views$;

CREATE FUNCTION fleet.refuse() RETURNS trigger LANGUAGE plpgsql SET search_path = pg_catalog AS $refuse$
BEGIN
  RAISE EXCEPTION 'fleet.%: nobody changes or deletes what was pushed', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
END $refuse$;

DO $keep$
DECLARE kept text;
BEGIN
  FOR kept IN SELECT relname FROM pg_class WHERE relnamespace = 'fleet'::regnamespace AND relkind IN ('r', 'p') LOOP
    EXECUTE format('CREATE TRIGGER kept_rows BEFORE UPDATE OR DELETE ON fleet.%I FOR EACH ROW '
      'EXECUTE FUNCTION fleet.refuse()', kept);
    EXECUTE format('CREATE TRIGGER kept_table BEFORE TRUNCATE ON fleet.%I FOR EACH STATEMENT '
      'EXECUTE FUNCTION fleet.refuse()', kept);
  END LOOP;
END $keep$;

-- Benches make the partitions that they need by this function alone.
CREATE FUNCTION fleet.make_month(month bigint) RETURNS void LANGUAGE plpgsql SECURITY DEFINER
SET search_path = pg_catalog, pg_temp AS $month$
DECLARE part text := format('frames_%s', month);
BEGIN
  IF month <> 0 AND (month NOT BETWEEN 197001 AND 999912 OR month % 100 NOT BETWEEN 1 AND 12) THEN
    RAISE EXCEPTION '% is no month', month;
  END IF;
  IF to_regclass('fleet.' || part) IS NOT NULL THEN RETURN; END IF;
  PERFORM pg_advisory_xact_lock(hashtext('fleet.make_month'));
  IF to_regclass('fleet.' || part) IS NOT NULL THEN RETURN; END IF;
  EXECUTE format('CREATE TABLE fleet.%I PARTITION OF fleet.frames FOR VALUES IN (%s)', part, month);
  EXECUTE format('ALTER TABLE fleet.%I ALTER COLUMN counts SET STORAGE EXTERNAL, '
    'ALTER COLUMN trace SET STORAGE EXTERNAL', part);
  EXECUTE format('CREATE TRIGGER kept_table BEFORE TRUNCATE ON fleet.%I FOR EACH STATEMENT '
    'EXECUTE FUNCTION fleet.refuse()', part);
END $month$;
REVOKE ALL ON FUNCTION fleet.make_month(bigint) FROM PUBLIC;

DO $roles$
DECLARE wanted text;
BEGIN
  FOREACH wanted IN ARRAY ARRAY['tactbench_bench', 'tactbench_analyst'] LOOP
    IF NOT EXISTS (SELECT 1 FROM pg_roles WHERE rolname = wanted) THEN
      EXECUTE format('CREATE ROLE %I NOLOGIN', wanted);
    END IF;
  END LOOP;
END $roles$;
GRANT USAGE ON SCHEMA fleet TO tactbench_bench, tactbench_analyst;
GRANT SELECT ON ALL TABLES IN SCHEMA fleet TO tactbench_bench, tactbench_analyst;
GRANT INSERT ON fleet.sensors, fleet.runs, fleet.sequences, fleet.devices, fleet.branches, fleet.events, fleet.checks,
  fleet.series, fleet.frames, fleet.fits, fleet.fit_taxels, fleet.revisions, fleet.verdicts, fleet.figures,
  fleet.reports, fleet.baselines, fleet.baseline_runs TO tactbench_bench;
GRANT EXECUTE ON FUNCTION fleet.make_month(bigint) TO tactbench_bench;
)sql";

constexpr std::array kMigrations = {kVersion1, "ALTER TABLE fleet.reports ADD COLUMN reason text NOT NULL DEFAULT ''"};
static_assert(kMigrations.size() == kFleetSchema);

}  // namespace

int schema_of(Link& link) {
  if (link.query("SELECT to_regclass('fleet.migrations')::text").front().front().empty()) return 0;
  return std::stoi(link.query("SELECT coalesce(max(version), 0) FROM fleet.migrations").front().front());
}

void check_schema(Link& link) {
  const int schema = schema_of(link);
  if (schema == kFleetSchema) return;
  if (schema == 0) {
    throw FleetError(FleetCause::kStore, "TB-FLEET-EMPTY",
                     fmt::format("fleet {}: this database holds no fleet yet", link.where()),
                     "who may create schemas and roles there makes it, once: tactbench fleet migrate --to CONNINFO");
  }
  if (schema < kFleetSchema) {
    throw FleetError(
        FleetCause::kStore, "TB-FLEET-OLDER",
        fmt::format("fleet {}: it has schema {}, this program needs {}", link.where(), schema, kFleetSchema),
        "who owns it brings it up to date: tactbench fleet migrate --to CONNINFO");
  }
  throw FleetError(
      FleetCause::kStore, "TB-FLEET-NEWER",
      fmt::format("fleet {}: it has schema {}, this program knows up to {}", link.where(), schema, kFleetSchema),
      "use the newer tactbench on this bench, too; until then its store keeps everything");
}

int migrate(Link& link, const std::string& program_version) {
  Transaction transaction(link);
  (void)link.query("SELECT pg_advisory_xact_lock(hashtext('tactbench fleet migrate'))");
  const int before = schema_of(link);
  if (before > kFleetSchema) check_schema(link);
  for (int schema = before; schema < kFleetSchema; ++schema) {
    link.execute(kMigrations.at(static_cast<std::size_t>(schema)));
    (void)link.query("INSERT INTO fleet.migrations (version, program_version) VALUES ($1, $2)",
                     {std::to_string(schema + 1), program_version});
  }
  transaction.commit();
  return before;
}

}  // namespace tactbench::db::fleet
