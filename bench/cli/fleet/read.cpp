// fleet runs, show, trend: the verbs of a store, on a copy of the runs that they need.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/fleet/fleet.h"
#include "bench/cli/runs/from_fleet.h"
#include "bench/cli/runs/runs_list.h"
#include "bench/cli/runs/trend.h"
#include "db/fleet/find.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

struct ReadOptions {
  std::string from, origin = "hardware", where, run;
};

// So that nobody takes the runs of one origin for all.
void tell_other_origins(fleet::Link& link, const ReadOptions& options, const Session& session) {
  if (session.json) return;
  for (const auto& [origin, runs] : fleet::runs_by_origin(link)) {
    if (origin != options.origin) tty::print(stderr, "{} {} left out (--origin {})\n", runs, origin, origin);
  }
}

void list_fleet(const ReadOptions& options, const RunsListOptions& list, Session& session) {
  FromFleet from(session, options.from);
  const std::vector<std::int64_t> runs = fleet::find_runs(from.link(), options.origin, options.where);
  const auto frames = fleet::frame_counts(from.link(), runs);
  from.take(runs, fleet::Frames::kWithout);
  list_runs(list, session, &frames);
  tell_other_origins(from.link(), options, session);
}

// A JSON document is one document, so what is the fleet's own goes into lines for people alone.
void show_fleet(const ReadOptions& options, Session& session) {
  FromFleet from(session, options.from);
  const std::int64_t run = from.run_named(options.run);
  from.take({run}, fleet::Frames::kWith);
  show_run(run, session);
  if (session.json) return;
  for (const fleet::TextRow& row : from.link().query(
           "SELECT r.pushed_by, to_char(r.pushed_at AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'), "
           "(SELECT count(*) FROM fleet.revisions v WHERE v.run = r.run), coalesce((SELECT v.source FROM "
           "fleet.revisions v "
           "WHERE v.run = r.run ORDER BY v.revision DESC LIMIT 1), '') FROM fleet.runs r WHERE r.run = $1",
           {std::to_string(run)}))
    tty::print("  {:<14}{}: pushed by {} on {}, from {}; revisions of what is said of it: {}\n", "fleet", session.fleet,
               row[0], row[1], row[3], row[2]);
  for (const fleet::TextRow& row : from.link().query(
           "SELECT model, program_version, created_utc, sha256, parent_sha256 FROM fleet.fits WHERE run = $1 "
           "ORDER BY fit",
           {std::to_string(run)}))
    tty::print("  {:<14}{} by {} on {}, sha256 {}{}\n", "fit", row[0], row[1], row[2], row[3].substr(0, 12),
               row[4].empty() ? "" : fmt::format(", child of {}", row[4].substr(0, 12)));
}

void trend_fleet(const ReadOptions& options, const TrendOptions& trend_options, Session& session) {
  FromFleet from(session, options.from);
  // Only runs with figures, since a list of all runs of a fleet is long.
  const std::string with_figures = "revision IN (SELECT revision FROM fleet.figures)";
  const std::string where =
      options.where.empty() ? with_figures : fmt::format("({}\n) AND {}", options.where, with_figures);
  from.take(fleet::find_runs(from.link(), options.origin, where), fleet::Frames::kWithout);
  tell_other_origins(from.link(), options, session);
  try {
    trend(trend_options, session);
  } catch (const Error& error) {
    if (error.id() != "TB-TREND-NONE") throw;
    throw Error(error.code(), error.id(), error.what(), fmt::format("{}, {} runs", session.fleet, options.origin),
                error.remedy());
  }
}

CLI::App* add_reader(CLI::App& group, const char* name, const char* about, ReadOptions& options, Session& session) {
  CLI::App* verb = group.add_subcommand(name, about);
  add_fleet_option(*verb, "--from", options.from, session);
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->add_flag("-q,--quiet", session.quiet, "only results");
  return verb;
}

void add_choice(CLI::App& verb, ReadOptions& options) {
  add_origin(verb, options.origin);
  verb.add_option("--where", options.where,
                  "condition in SQL over the columns of fleet.every_run: \"sensor_type = 'array-16' AND bench_id = "
                  "'bench-2'\"");
}

}  // namespace

void add_fleet_readers(CLI::App& group, Session& session) {
  auto options = std::make_shared<ReadOptions>();
  auto list = std::make_shared<RunsListOptions>();
  auto figures = std::make_shared<TrendOptions>();
  CLI::App* runs = add_reader(group, "runs", "one line a run of the fleet, as runs list", *options, session);
  add_choice(*runs, *options);
  add_runs_list_options(*runs, *list);
  runs->callback([options, list, &session] { list_fleet(*options, *list, session); });
  CLI::App* show =
      add_reader(group, "show", "everything stored about a run of the fleet, as runs show", *options, session);
  show->add_option("run", options->run, "the fleet's number of the run, or its UUID or the beginning of it")
      ->required();
  add_units(*show, session);
  show->callback([options, &session] { show_fleet(*options, session); });
  CLI::App* over_time = add_reader(group, "trend", "figures of the fleet over time, as trend", *options, session);
  add_choice(*over_time, *options);
  add_trend_options(*over_time, *figures, session);
  over_time->callback([options, figures, &session] { trend_fleet(*options, *figures, session); });
}

}  // namespace tactbench::bench
