#include "db/fleet/runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "db/fleet/run_archive.h"
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

}  // namespace tactbench::db::fleet
