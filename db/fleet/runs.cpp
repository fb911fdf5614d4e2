#include "db/fleet/runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#define ZLIB_CONST  // what is read is not written
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "db/run_store.h"

namespace tactbench::db::fleet {
namespace {

constexpr const char* kColumns =
    "r.run::text, r.revision::text, r.uuid, r.content_sha256, r.facts::text, r.pushed_by, "
    "to_char(r.pushed_at AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'), r.source";
constexpr std::size_t kColumnCount = 8;

constexpr std::size_t kLargestList = 1 << 30;  // bytes: some 300 000 runs

std::vector<FleetRun> runs_in(Link& link, const std::string& rest, const std::vector<std::string>& parameters) {
  std::vector<FleetRun> runs;
  for (Row& row : link.query(fmt::format("SELECT {} FROM fleet.every_run r {}", kColumns, rest), kColumnCount,
                             parameters, kLargestList))
    runs.push_back({link.number(row[0]), link.number(row[1]), std::move(row[2]), std::move(row[3]), std::move(row[4]),
                    std::move(row[5]), std::move(row[6]), std::move(row[7])});
  return runs;
}

bool consists_of(const std::string& text, const char* characters) {
  return !text.empty() && text.find_first_not_of(characters) == std::string::npos;
}

}  // namespace

std::vector<KnownRow> known_rows(Link& link, const std::vector<std::string>& uuids) {
  std::vector<KnownRow> known;
  for (Row& row : link.query("SELECT uuid, content_sha256, said_sha256, source FROM fleet.runs "
                             "WHERE uuid = ANY(string_to_array($1::text, ' ')) ORDER BY revision",
                             4, {fmt::format("{}", fmt::join(uuids, " "))}))
    known.push_back({std::move(row[0]), std::move(row[1]), std::move(row[2]), std::move(row[3])});
  return known;
}

std::int64_t add_run(Link& link, const SentRun& run) {
  Transaction transaction(link);
  const std::string sha256 = sha256_hex(run.body);
  const std::vector<Row> added = link.query(
      "INSERT INTO fleet.runs (uuid, content_sha256, said_sha256, source, facts, body, body_sha256) VALUES "
      "($1::text, $2::text, $3::text, $4::text, $5::text::jsonb, $6::bytea, $7::text) RETURNING run::text, "
      "revision::text",
      2, {run.uuid, run.content_sha256, run.said_sha256, run.source, run.facts, run.body, sha256});
  if (added.empty())  // another push was faster
    return link.number(
        link.query_row("SELECT run::text FROM fleet.owners WHERE uuid = $1::text", 1, {run.uuid}).front());
  const Row back = link.query_row("SELECT uuid, content_sha256, body FROM fleet.runs WHERE revision = $1::text::bigint",
                                  3, {added.front()[1]}, run.body.size() + kMaxAnswerBytes);
  if (back[0] != run.uuid || back[1] != run.content_sha256 || sha256_hex(back[2]) != sha256)
    throw FleetError(FleetCause::kStore, "TB-FLEET-DIFFERS",
                     fmt::format("fleet {}: run {} reached the server changed", link.where(), run.uuid),
                     "nothing was stored there: push again, and report it if it recurs");
  transaction.commit();
  return link.number(added.front()[0]);
}

FleetRun find_run_by_name(Link& link, const std::string& name) {
  constexpr std::size_t kLongest = 18, kShortestUuid = 4;
  std::vector<FleetRun> found;
  if (consists_of(name, "0123456789") && name.size() <= kLongest)
    found = runs_in(link, "WHERE r.run = $1::text::bigint", {name});
  if (found.empty() && name.size() >= kShortestUuid && consists_of(name, "0123456789abcdefABCDEF-"))
    found = runs_in(link, "WHERE starts_with(r.uuid, lower($1::text)) LIMIT 2", {name});
  if (found.size() == 1) return found.front();
  throw FleetError(FleetCause::kUsage, "TB-FLEET-NOT-FOUND",
                   fmt::format("fleet {} has {} '{}'", link.where(), found.empty() ? "no run" : "several runs", name),
                   "tactbench fleet runs lists them by the fleet's own numbers; a UUID also names a run");
}

std::vector<FleetRun> find_runs(Link& link, const std::string& origin, const std::string& where) {
  const Transaction reading(link, "READ ONLY");
  link.execute("SET LOCAL statement_timeout = '60s'");
  try {
    return runs_in(link,
                   fmt::format("WHERE origin = $1::text AND run IN (SELECT run FROM fleet.every_run WHERE ({}\n)) "
                               "ORDER BY started_utc, run",
                               where.empty() ? "true" : where),
                   {origin});
  } catch (const FleetError& error) {
    if (where.empty() || (error.id() != "TB-FLEET-SQL" && error.id() != "TB-FLEET-DENIED")) throw;
    throw FleetError(FleetCause::kUsage, "TB-FLEET-WHERE",
                     fmt::format("the condition \"{}\" cannot be used: {}", where, error.what()),
                     "a condition in SQL over the columns of fleet.every_run: \"sensor_type = 'array-16' AND bench_id "
                     "= 'bench-2'\"");
  }
}

std::map<std::string, std::int64_t> runs_by_origin(Link& link) {
  std::map<std::string, std::int64_t> counts;
  for (const Row& row : link.query("SELECT origin, count(*)::text FROM fleet.every_run GROUP BY origin", 2))
    counts[row[0]] = link.number(row[1]);
  return counts;
}

std::vector<FleetRun> with_dependencies(Link& link, const FleetRun& run) {
  return runs_in(link,
                 "WHERE r.run IN (WITH RECURSIVE needed(run, facts) AS (SELECT run, facts FROM fleet.every_run "
                 "WHERE run = $1::text::bigint UNION SELECT e.run, e.facts FROM needed n CROSS JOIN LATERAL "
                 "jsonb_array_elements_text(fleet.list(n.facts->'rests_on')) AS c(uuid) "
                 "JOIN fleet.every_run e ON e.uuid = c.uuid) SELECT run FROM needed) ORDER BY r.run",
                 {std::to_string(run.run)});
}

std::string body_of(Link& link, const FleetRun& run) {
  Row row = link.query_row("SELECT body_sha256, body FROM fleet.runs WHERE revision = $1::text::bigint", 2,
                           {std::to_string(run.revision)}, kMaxStoreBytes + kMaxAnswerBytes);
  if (sha256_hex(row[1]) == row[0]) return std::move(row[1]);
  throw FleetError(FleetCause::kStore, "TB-FLEET-CHANGED",
                   fmt::format("fleet {}: run {} differs from what was pushed", link.where(), run.run),
                   "somebody changed the fleet's tables: use the run in the bench's own store");
}

std::string pack_run(const RunReader& store, std::int64_t run, const std::string& scratch) {
  const std::string path = scratch + "/packed.db";
  for (const char* ending : {"", "-wal", "-shm"}) std::filesystem::remove(path + ending);
  // A copy checks the content and the sealed records that it copies.
  (void)RunStore::open(path, Durability::kNormal).copy_runs_from(store, {run});
  std::string plain(std::filesystem::file_size(path), '\0');
  if (plain.size() > kMaxStoreBytes)
    throw FleetError(FleetCause::kStore, "TB-FLEET-LARGE",
                     fmt::format("run {} has {} MB, but the fleet keeps runs up to {} MB", run,
                                 plain.size() / 1'000'000, kMaxStoreBytes / 1'000'000),
                     "the run stays in the store; back the store up instead (tactbench runs copy --to FILE)");
  std::ifstream(path, std::ios::binary).read(plain.data(), static_cast<std::streamsize>(plain.size()));
  std::filesystem::remove(path);
  uLongf size = compressBound(plain.size());
  std::string body(size, '\0');
  (void)compress(reinterpret_cast<Bytef*>(body.data()), &size, reinterpret_cast<const Bytef*>(plain.data()),
                 plain.size());
  body.resize(size);
  return body;
}

void unpack_run(const std::string& body, const std::string& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  std::string piece(1 << 18, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<const Bytef*>(body.data());
  stream.avail_in = static_cast<uInt>(std::min(body.size(), kMaxStoreBytes));
  int state = inflateInit(&stream);
  while (state == Z_OK && stream.total_out <= kMaxStoreBytes && file) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    state = inflate(&stream, Z_NO_FLUSH);
    file.write(piece.data(), static_cast<std::streamsize>(piece.size() - stream.avail_out));
  }
  const bool whole = state == Z_STREAM_END && stream.total_in == body.size();
  inflateEnd(&stream);
  file.close();
  if (!file)
    throw StoreError("TB-STORE-FULL", fmt::format("{} could not be written", path), "free space for temporary files");
  if (!whole)
    throw FleetError(FleetCause::kStore, "TB-FLEET-CHANGED",
                     "the pushed data of the run are not a store compressed by zlib",
                     "use the run in the bench's own store");
}

namespace {

constexpr const char* kSchemaSql = R"sql(
CREATE SCHEMA fleet;
CREATE TABLE fleet.about (schema bigint NOT NULL, program_version text NOT NULL, made_at timestamptz NOT NULL DEFAULT now());

-- Who pushed a run first owns it, and the fleet's number of the run.
CREATE TABLE fleet.owners (
  uuid text PRIMARY KEY CHECK (uuid ~ '^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$'),
  run bigint GENERATED ALWAYS AS IDENTITY UNIQUE,
  owner text NOT NULL
);

-- A row is a run as a bench had it at one push. What changed later is a further row; of a run the one with the greatest
-- revision counts. Revision, run, pushed_by and pushed_at are given by the trigger below, whatever a bench sends.
CREATE SEQUENCE fleet.revisions;
CREATE TABLE fleet.runs (
  revision bigint PRIMARY KEY,
  run bigint NOT NULL REFERENCES fleet.owners (run),
  uuid text NOT NULL REFERENCES fleet.owners (uuid),
  content_sha256 text NOT NULL CHECK (content_sha256 ~ '^[0-9a-f]{64}$'),  -- of the run's canonical content
  said_sha256 text NOT NULL CHECK (said_sha256 ~ '^[0-9a-f]{64}$'),        -- of that and of all that is said of the run
  source text NOT NULL CHECK (length(source) <= 5000),                     -- the store: host and file
  -- What people ask by: the keys of `tactbench runs list --json`, and fits, verdicts, figures, reports.
  facts jsonb NOT NULL CHECK (jsonb_typeof(facts) = 'object' AND length(facts::text) <= 8000000
    AND coalesce(facts->>'origin', '') IN ('hardware', 'simulated', 'imported')),
  body bytea NOT NULL,                                                     -- a store (SQLite) with this run, by zlib
  body_sha256 text NOT NULL CHECK (body_sha256 = encode(sha256(body), 'hex')),
  pushed_by text NOT NULL,
  pushed_at timestamptz NOT NULL
);
ALTER TABLE fleet.runs ALTER COLUMN body SET STORAGE EXTERNAL;  -- it is compressed already
CREATE INDEX runs_by_uuid ON fleet.runs (uuid, revision);
CREATE INDEX runs_by_content ON fleet.runs (content_sha256);
CREATE INDEX runs_by_sensor ON fleet.runs ((facts->>'sensor'), (facts->>'started_utc'));
CREATE INDEX runs_by_bench ON fleet.runs ((facts->>'bench'), (facts->>'started_utc'));
CREATE INDEX runs_by_facts ON fleet.runs USING gin (facts jsonb_path_ops);

-- session_user is who logged in, also within this function, which runs with the rights of its owner. The lock on the
-- owner's row lasts to the transaction's end, so that revisions of a run are committed in their order.
CREATE FUNCTION fleet.seal() RETURNS trigger LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $seal$
DECLARE
  holder text;
  newest record;
BEGIN
  INSERT INTO fleet.owners (uuid, owner) VALUES (NEW.uuid, session_user) ON CONFLICT (uuid) DO NOTHING;
  SELECT o.run, o.owner INTO NEW.run, holder FROM fleet.owners o WHERE o.uuid = NEW.uuid FOR UPDATE;
  IF holder <> session_user THEN
    RAISE EXCEPTION 'run % was pushed by %, and this is %', NEW.uuid, holder, session_user USING ERRCODE = 'TB001';
  END IF;
  SELECT r.content_sha256, r.said_sha256 INTO newest FROM fleet.runs r WHERE r.uuid = NEW.uuid ORDER BY r.revision DESC LIMIT 1;
  IF newest.content_sha256 = NEW.content_sha256 AND newest.said_sha256 = NEW.said_sha256 THEN
    RETURN NULL;  -- it is there already: two pushes at the same time
  END IF;
  NEW.revision := nextval('fleet.revisions');
  NEW.pushed_by := session_user;
  NEW.pushed_at := now();
  RETURN NEW;
END $seal$;
CREATE TRIGGER seal BEFORE INSERT ON fleet.runs FOR EACH ROW EXECUTE FUNCTION fleet.seal();

-- It holds for the tables' owner, too.
CREATE FUNCTION fleet.refuse() RETURNS trigger LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $refuse$
BEGIN
  RAISE EXCEPTION 'fleet.%: nobody changes or deletes what was pushed', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
END $refuse$;
CREATE TRIGGER kept_rows BEFORE UPDATE OR DELETE ON fleet.runs FOR EACH ROW EXECUTE FUNCTION fleet.refuse();
CREATE TRIGGER kept_table BEFORE TRUNCATE ON fleet.runs FOR EACH STATEMENT EXECUTE FUNCTION fleet.refuse();

-- Facts are what a bench says. These never fail, so that no row hides another from who reads a view.
CREATE FUNCTION fleet.list(jsonb) RETURNS jsonb LANGUAGE sql IMMUTABLE AS
$$ SELECT CASE WHEN jsonb_typeof($1) = 'array' THEN $1 ELSE '[]' END $$;
CREATE FUNCTION fleet.members(jsonb) RETURNS jsonb LANGUAGE sql IMMUTABLE AS
$$ SELECT CASE WHEN jsonb_typeof($1) = 'object' THEN $1 ELSE '{}' END $$;
CREATE FUNCTION fleet.number(jsonb) RETURNS numeric LANGUAGE sql IMMUTABLE AS
$$ SELECT CASE WHEN jsonb_typeof($1) = 'number' THEN $1::numeric END $$;

-- Each run once, as it is now.
CREATE VIEW fleet.every_run AS
SELECT r.run, r.uuid, facts->>'origin' AS origin, facts->>'outcome' AS outcome, facts->>'reason' AS reason,
  facts->>'safe_state' AS safe_state, facts->>'operator' AS operator, facts->>'purpose' AS purpose,
  facts->>'sensor' AS sensor_serial, facts->>'sensor_type' AS sensor_type, facts->>'scanner' AS scanner_serial,
  facts->>'bench' AS bench_id,
  (SELECT string_agg(q->>'name', ', ' ORDER BY n) FROM jsonb_array_elements(fleet.list(facts->'recipes'))
   WITH ORDINALITY AS each(q, n)) AS recipes,
  fleet.number(facts->'frames') AS frames, facts->>'verdict' AS verdict, facts->>'program_version' AS program_version,
  facts->>'git_commit' AS git_commit, facts->'git_dirty' = 'true' AS git_dirty, fleet.number(facts->'seed') AS seed,
  fleet.number(facts->'sensor_seed') AS sensor_seed, facts->>'started_utc' AS started_utc,
  facts->>'ended_utc' AS ended_utc, fleet.number(facts->'rest_s') AS rest_s, r.content_sha256,
  coalesce((SELECT string_agg(t, ' ' ORDER BY n) FROM jsonb_array_elements_text(fleet.list(facts->'tags'))
   WITH ORDINALITY AS each(t, n)), '') AS tags,
  facts->>'notes' AS notes, coalesce(facts->'void' = 'true', false) AS void, facts->>'void_reason' AS void_reason,
  facts->>'void_by' AS void_by, facts->>'void_utc' AS void_utc, facts->>'host' AS host, r.source, r.revision,
  r.pushed_by, r.pushed_at, r.facts
FROM fleet.runs r
WHERE NOT EXISTS (SELECT 1 FROM fleet.runs n WHERE n.uuid = r.uuid AND n.revision > r.revision);
CREATE VIEW fleet.every_verdict AS
SELECT r.run, r.uuid, r.origin, r.sensor_serial, r.started_utc, r.void, v->>'criterion' AS criterion,
  v->'scope'->>'kind' AS scope_kind, fleet.number(coalesce(v->'scope'->'psi', v->'scope'->'low_psi')) AS low_psi,
  fleet.number(coalesce(v->'scope'->'psi', v->'scope'->'high_psi')) AS high_psi, v->'scope'->>'direction' AS direction,
  fleet.number(v->'scope'->'share') AS taxel_share, fleet.number(v->'value') AS value,
  fleet.number(v->'expanded') AS expanded, fleet.number(v->'limit') AS limit_value, v->>'unit' AS unit, v->>'rule' AS rule,
  v->>'verdict' AS verdict, v->>'limits_sha256' AS limits_sha256, v->>'models_of' AS models_of_content
FROM fleet.every_run r CROSS JOIN LATERAL jsonb_array_elements(fleet.list(r.facts->'verdicts')) AS v;
CREATE VIEW fleet.every_figure AS
SELECT r.run, r.uuid, r.origin, r.sensor_serial, r.bench_id, r.started_utc, r.void, s.key AS subject, f.key AS name,
  fleet.number(f.value) AS value
FROM fleet.every_run r CROSS JOIN LATERAL jsonb_each(fleet.members(r.facts->'figures')) AS s
CROSS JOIN LATERAL jsonb_each(fleet.members(s.value)) AS f;
CREATE VIEW fleet.every_fit AS
SELECT r.run, r.uuid, r.origin, r.sensor_serial, r.started_utc, r.void, f->>'model' AS model,
  f->>'program_version' AS program_version, f->>'created_utc' AS created_utc
FROM fleet.every_run r CROSS JOIN LATERAL jsonb_array_elements(fleet.list(r.facts->'fits')) AS f;
-- One set of views for each origin, since origins never mix: hardware_runs, simulated_verdicts, imported_fits ...
DO $views$
DECLARE origin text; what text;
BEGIN
  FOREACH origin IN ARRAY ARRAY['hardware', 'simulated', 'imported'] LOOP
    FOREACH what IN ARRAY ARRAY['run', 'verdict', 'figure', 'fit'] LOOP
      EXECUTE format('CREATE VIEW fleet.%s_%ss AS SELECT * FROM fleet.every_%s WHERE origin = %L', origin, what, what, origin);
    END LOOP;
  END LOOP;
END $views$;

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
GRANT INSERT (uuid, content_sha256, said_sha256, source, facts, body, body_sha256) ON fleet.runs TO tactbench_bench;
)sql";

}  // namespace

int schema_of(Link& link) {
  if (link.query_row("SELECT coalesce(to_regclass('fleet.about')::text, '')", 1).front().empty()) return 0;
  return static_cast<int>(link.number(link.query_row("SELECT max(schema)::text FROM fleet.about", 1).front()));
}

void check_schema(Link& link) {
  const int schema = schema_of(link);
  if (schema == kFleetSchema) return;
  if (schema == 0)
    throw FleetError(FleetCause::kStore, "TB-FLEET-EMPTY",
                     fmt::format("fleet {}: this database holds no fleet yet", link.where()),
                     "make it once, as a role that may create schemas and roles: tactbench fleet migrate");
  throw FleetError(
      FleetCause::kStore, "TB-FLEET-SCHEMA",
      fmt::format("fleet {}: it has schema {}, but this program writes {}", link.where(), schema, kFleetSchema),
      "use the version of tactbench that made it, or another database");
}

int make_fleet(Link& link, const std::string& program_version) {
  Transaction transaction(link);
  (void)link.query("SELECT pg_advisory_xact_lock(hashtext('fleet'))::text", 1);
  const int before = schema_of(link);
  if (before != 0) {
    check_schema(link);
    return before;
  }
  if (const std::string encoding = link.query_row("SHOW server_encoding", 1).front(); encoding != "UTF8")
    throw FleetError(FleetCause::kStore, "TB-FLEET-TEXT",
                     fmt::format("fleet {}: the database's encoding is {}", link.where(), encoding),
                     "make one that keeps every text: createdb --encoding UTF8 --template template0 NAME");
  link.execute(kSchemaSql);
  (void)link.query("INSERT INTO fleet.about (schema, program_version) VALUES ($1::text::bigint, $2::text)", 0,
                   {std::to_string(kFleetSchema), program_version});
  transaction.commit();
  return before;
}

}  // namespace tactbench::db::fleet
