#include "db/fleet/find.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tactbench::db::fleet {

namespace {

bool all_of(const std::string& text, const char* characters) {
  return !text.empty() && text.find_first_not_of(characters) == std::string::npos;
}

void add_found(const std::vector<TextRow>& rows, std::vector<std::int64_t>& runs) {
  for (const TextRow& row : rows) {
    const std::int64_t run = std::stoll(row.front());
    if (std::ranges::find(runs, run) == runs.end()) runs.push_back(run);
  }
}

}  // namespace

std::string number_array(const std::vector<std::int64_t>& numbers) {
  return fmt::format("{{{}}}", fmt::join(numbers, ","));
}

std::int64_t run_named(Link& link, const std::string& name) {
  constexpr std::size_t kLongest = 18, kShortestUuid = 4;
  std::vector<TextRow> found;
  if (all_of(name, "0123456789") && name.size() <= kLongest)
    found = link.query("SELECT run FROM fleet.runs WHERE run = $1", {name});
  if (found.empty() && name.size() >= kShortestUuid && all_of(name, "0123456789abcdefABCDEF-"))
    found = link.query("SELECT run FROM fleet.every_run WHERE starts_with(uuid, lower($1)) LIMIT 2", {name});
  if (found.size() == 1) return std::stoll(found.front().front());
  throw FleetError(FleetCause::kUsage, "TB-FLEET-NOT-FOUND",
                   fmt::format("fleet {} has {} '{}'", link.where(), found.empty() ? "no run" : "several runs", name),
                   "tactbench fleet runs lists them by the fleet's own numbers; a UUID names a run, too");
}

std::vector<std::int64_t> find_runs(Link& link, const std::string& origin, const std::string& where) {
  std::vector<std::int64_t> runs;
  const Transaction reading(link, "READ ONLY");
  try {
    add_found(
        link.query(fmt::format("SELECT run FROM fleet.every_run WHERE origin = $1 AND ({}\n) ORDER BY started_utc, run",
                               where.empty() ? "true" : where),
                   {origin}),
        runs);
  } catch (const FleetError& error) {
    if (where.empty() || (error.id() != "TB-FLEET-SQL" && error.id() != "TB-FLEET-DENIED")) throw;
    throw FleetError(
        FleetCause::kUsage, "TB-FLEET-WHERE",
        fmt::format("the condition \"{}\" cannot be used: {}", where, error.what()),
        "a condition in SQL over the columns of fleet.every_run: \"sensor_type = 'array-16' AND bench_id = "
        "'bench-2'\"");
  }
  return runs;
}

std::map<std::string, std::int64_t> runs_by_origin(Link& link) {
  std::map<std::string, std::int64_t> counts;
  for (const TextRow& row : link.query("SELECT origin, count(*) FROM fleet.every_run GROUP BY origin"))
    counts[row[0]] = std::stoll(row[1]);
  return counts;
}

std::vector<std::int64_t> with_what_they_rest_on(Link& link, const std::vector<std::int64_t>& runs) {
  std::vector<std::int64_t> all = runs;
  add_found(link.query("SELECT DISTINCT m.run FROM fleet.every_run r JOIN fleet.verdicts v ON v.revision = r.revision "
                       "JOIN fleet.every_run m ON m.uuid = v.fit_uuid WHERE r.run = ANY($1::bigint[])",
                       {number_array(runs)}),
            all);
  // A dynamic model's document names the content of the runs that its lag and creep are from.
  add_found(link.query("SELECT DISTINCT m.run FROM fleet.fits f CROSS JOIN LATERAL "
                       "regexp_matches(f.patterns_json, '\"([0-9a-f]{64})\"', 'g') AS named(hash) "
                       "JOIN fleet.every_run m ON m.content_sha256 = named.hash[1] "
                       "WHERE f.run = ANY($1::bigint[]) AND f.model = 'dynamic'",
                       {number_array(all)}),
            all);
  return all;
}

std::map<std::int64_t, std::int64_t> frame_counts(Link& link, const std::vector<std::int64_t>& runs) {
  std::map<std::int64_t, std::int64_t> counts;
  for (const TextRow& row :
       link.query("SELECT run, frames FROM fleet.runs WHERE run = ANY($1::bigint[])", {number_array(runs)}))
    counts[std::stoll(row[0])] = std::stoll(row[1]);
  return counts;
}

}  // namespace tactbench::db::fleet
