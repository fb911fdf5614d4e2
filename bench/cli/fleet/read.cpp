// fleet runs, show, trend: the verbs of a store, on the facts of the fleet's runs, or on a copy of those that they
// need.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/cli/runs/from_fleet.h"
#include "bench/cli/runs/runs_list.h"
#include "bench/cli/runs/trend.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;
using Json = nlohmann::ordered_json;

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

// What the list shows of a run, from its facts. Throws nlohmann::json::exception where they are none.
ListedRun listed_run(const fleet::FleetRun& run, const Json& facts) {
  ListedRun listed;
  listed.run.run = run.run;
  facts.at("origin").get_to(listed.run.origin);
  facts.at("sensor").get_to(listed.run.sensor_serial);
  facts.at("started_utc").get_to(listed.run.started_utc);
  facts.at("purpose").get_to(listed.run.purpose);
  facts.at("tags").get_to(listed.run.tags);
  facts.at("void_reason").get_to(listed.run.void_reason);
  facts.at("void_utc").get_to(listed.run.void_utc);
  facts.at("frames").get_to(listed.frames);
  listed.run.outcome = db::outcome_from(facts.at("outcome").get<std::string>()).value_or(db::Outcome::kFailed);
  if (facts.at("verdict").is_string()) listed.verdict = analysis::verdict_from(facts["verdict"].get<std::string>());
  for (const Json& recipe : facts.at("recipes")) recipe.at("name").get_to(listed.run.sequences.emplace_back().name);
  return listed;
}

// The keys of `runs list --json`.
Json row_of(const fleet::FleetRun& run, Json facts) {
  for (const char* more : {"fits", "verdicts", "figures", "reports", "rests_on", "sensor_type"}) facts.erase(more);
  facts["run"] = run.run;
  return facts;
}

void list_fleet(const ReadOptions& options, const RunsListOptions& wanted, Session& session) {
  FromFleet from(session, options.from);
  RunsList list(wanted, session);
  const std::vector<fleet::FleetRun> runs = fleet::find_runs(from.link(), options.origin, options.where);
  for (const fleet::FleetRun& run : runs) {
    try {
      const Json facts = analysis::parse_ordered_json(run.facts);
      const ListedRun listed = listed_run(run, facts);
      if (!wanted.sensor.empty() && listed.run.sensor_serial != wanted.sensor) continue;
      if (listed.run.started_utc < wanted.since || !list.takes(listed.run, listed.verdict)) continue;
      list.add(listed, session.json ? row_of(run, facts) : Json());
    } catch (const nlohmann::json::exception& error) {  // a bench may say anything; it hides nobody's run but its own
      tty::print(stderr, "warning: run {}, pushed by {}: its facts cannot be read: {}\n", run.run,
                 one_line(run.pushed_by), one_line(error.what()));
    }
  }
  list.end(!runs.empty());
  tell_other_origins(from.link(), options, session);
}

// A JSON document is one document, so what is the fleet's own goes into lines for people alone.
void show_fleet(const ReadOptions& options, Session& session) {
  FromFleet from(session, options.from);
  const fleet::FleetRun run = fleet::run_named(from.link(), options.run);
  from.take({run});
  show_run(run.run, session);
  if (!session.json)
    tty::print("fleet {}: pushed by {} on {}, from {}\n", session.fleet, run.pushed_by, run.pushed_utc, run.source);
}

void trend_fleet(const ReadOptions& options, const TrendOptions& trend_options, Session& session) {
  FromFleet from(session, options.from);
  std::vector<fleet::FleetRun> runs;  // with figures, since a list of all runs of a fleet is long
  for (fleet::FleetRun& run : fleet::find_runs(from.link(), options.origin, options.where)) {
    const nlohmann::json facts = analysis::try_json(run.facts);
    const bool has = facts.is_object() && facts.contains("figures") && !facts["figures"].empty();
    if (has && (trend_options.sensor.empty() || facts.value("sensor", nlohmann::json()) == trend_options.sensor))
      runs.push_back(std::move(run));
  }
  from.take({}, runs);
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
  return verb;
}

void add_choice(CLI::App& verb, ReadOptions& options) {
  verb.add_option("--origin", options.origin, "runs of this origin; origins never mix")
      ->check(CLI::IsMember({"hardware", "simulated", "imported"}))
      ->capture_default_str();
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
  show->callback([options, &session] { show_fleet(*options, session); });
  CLI::App* over_time = add_reader(group, "trend", "figures of the fleet over time, as trend", *options, session);
  add_choice(*over_time, *options);
  add_trend_options(*over_time, *figures, session);
  over_time->callback([options, figures, &session] { trend_fleet(*options, *figures, session); });
}

}  // namespace tactbench::bench
