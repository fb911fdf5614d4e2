// fleet: the group of verbs, what they share, and fleet migrate.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/cli/runs/runs.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/runs/trend.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/private_files.h"
#include "bench/fleet/facts.h"
#include "db/fleet/runs.h"

namespace tactbench::bench {

namespace {

void migrate_fleet(const std::string& to, const Session& session) {
  db::fleet::Link link(to);
  const int before = db::fleet::make_fleet(link, build_info().version);
  if (session.json) {
    print_json("fleet.migrate",
               {{"fleet", link.where()}, {"schema_before", before}, {"schema_now", db::fleet::kFleetSchema}});
  } else if (before != 0) {
    tty::print("{}: has schema {} already\n", link.where(), before);
  } else {
    tty::print(
        "{}: made a fleet with schema {}; benches log in as members of role tactbench_bench, readers of "
        "tactbench_analyst\n",
        link.where(), db::fleet::kFleetSchema);
  }
}

// Option that names the fleet: --to where a verb writes, --from where it reads; otherwise TACTBENCH_FLEET or
// tactbench.toml.
void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session) {
  session.profile
      .add(verb, name, ProfileKey::kFleet, value,
           std::string_view(name) == "--to"
               ? "connection string of the fleet's PostgreSQL, as for psql: \"host=db.lab dbname=tactile "
                 "user=bench_a sslmode=verify-full\", \"service=NAME\"; keep the password in ~/.pgpass"
               : "connection string of the fleet, as --to of fleet push")
      ->required();
}

}  // namespace

void add_fleet(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand("fleet", "runs of several benches in one PostgreSQL: push, read");
  group->require_subcommand(1);
  auto to = std::make_shared<std::string>();
  CLI::App* migrate = group->add_subcommand("migrate", "make the fleet's tables, views and roles in a database");
  add_fleet_option(*migrate, "--to", *to, session);
  migrate->callback([to, &session] { migrate_fleet(*to, session); });
  add_subverbs(*group, session);
}

// fleet push: sends ended runs to the fleet.

namespace {

namespace fleet = db::fleet;

struct PushOptions {
  std::string to;
  int patience_s = static_cast<int>(fleet::kSilence.count());
};

// A fault of one run, which is left for later; any other ends the push.
bool is_of_one_run(const Error& error) {
  return error.code() == ExitCode::kStore && error.id() != "TB-FLEET-FULL" && error.id() != "TB-FLEET-DENIED" &&
         error.id() != "TB-STORE-FULL";
}

void push(const PushOptions& options, Session& session) {
  fleet::Link link(options.to, std::chrono::seconds(options.patience_s));
  fleet::check_schema(link);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const ScratchFolder folder("tactbench-fleet");
  const std::string source = source_name(session.db);
  const std::vector<LocalRun> ended = ended_runs(store);
  auto pushed = nlohmann::ordered_json::array(), left = nlohmann::ordered_json::array();
  std::int64_t all_frames = 0;
  std::exception_ptr first;  // thrown when the other runs are there
  for (const LocalRun& one : waiting_runs(link, ended, source)) {
    const db::RunRecord& run = one.run;
    try {
      const std::int64_t number =
          fleet::add_run(link, {run.uuid, run.content_sha256, one.said_sha256, source, facts_of(store, run),
                                fleet::pack_run(store, run.run, folder.path())});
      const std::int64_t frames = one.content ? store.frame_count(run.run) : 0;
      const std::size_t fits = store.fits(run.run).size();
      all_frames += frames;
      pushed.push_back({JSON_FIELDS(run, run, uuid),
                        {"fleet_run", number},
                        {"frames", frames},
                        {"fits", fits},
                        {"remarks", !one.content}});
      if (session.json || session.quiet) continue;
      tty::print("run {} is the fleet's run {}: {}{}\n", run.run, number,
                 one.content ? analysis::counted(frames, "frame") : std::string("later records about it"),
                 fits > 0 ? fmt::format(", {}", analysis::counted(fits, "fit")) : "");
      std::fflush(stdout);
    } catch (...) {
      const Error error = as_error(std::current_exception());
      if (!is_of_one_run(error)) throw;
      if (!first) first = std::current_exception();
      left.push_back({JSON_FIELDS(run, run, uuid), {"id", error.id()}});
      if (!session.json) tty::print("run {} is not sent: {} [{}]\n", run.run, one_line(error.what()), error.id());
    }
  }
  if (session.json)
    print_json("fleet.push", {{"fleet", link.where()},
                              {"store", session.db},
                              {"ended_runs", ended.size()},
                              {"pushed", pushed},
                              {"frames", all_frames},
                              {"not_pushed", left.size()},
                              {"left", left}});
  else if (!session.quiet)
    tty::print("{}: {}, {} sent now; {} ended in {}, {}\n", link.where(), analysis::counted(pushed.size(), "run"),
               analysis::counted(all_frames, "frame"), analysis::counted(ended.size(), "run has", "runs have"),
               session.db, left.empty() ? "and all are there" : fmt::format("{} could not be sent", left.size()));
  if (first) std::rethrow_exception(first);
}

}  // namespace

void add_fleet_push(CLI::App& group, Session& session) {
  auto options = std::make_shared<PushOptions>();
  CLI::App* verb = group.add_subcommand("push", "send ended runs, and later records about them, to the fleet");
  add_fleet_option(*verb, "--to", options->to, session);
  verb->add_option("--patience", options->patience_s,
                   "seconds without a byte from the server until it counts as lost; use more for an overloaded server")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  verb->footer(
      "Each run is checked, sent in one transaction, read back, and kept if it equals what was sent. A run that has "
      "changed since it was stored (tactbench verify) is not sent; the others are. The store is only read: a live run "
      "is not affected.\n"
      "Exit codes: 0 the fleet has all runs, 3 the server cannot be reached, refuses the login or was lost, 5 it "
      "cannot store a run.");
  verb->callback([options, &session] { push(*options, session); });
}

// fleet status: how far the store is behind.

namespace {

std::string backlog_text(std::size_t ended, std::size_t runs, std::size_t remarks, std::int64_t frames) {
  if (ended == 0) return "no run has ended yet\n";
  std::string text = fmt::format("{} of {} there", ended - runs, analysis::counted(ended, "ended run"));
  if (runs > 0)
    text += fmt::format("; {} with {} waiting", analysis::counted(runs, "run"), analysis::counted(frames, "frame"));
  if (remarks > 0) text += fmt::format("; {} changed since and not sent", analysis::counted(remarks, "run"));
  return text + (runs + remarks == 0 ? "; nothing waits\n" : "; tactbench fleet push sends it\n");
}

void status(const std::string& to, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::vector<LocalRun> ended = ended_runs(store);
  fleet::Link link(to);
  fleet::check_schema(link);
  std::size_t runs = 0, remarks = 0;  // remarks: runs in the fleet with newer records here
  std::int64_t frames = 0;
  for (const LocalRun& one : waiting_runs(link, ended, source_name(session.db))) {
    ++(one.content ? runs : remarks);
    if (one.content) frames += store.frame_count(one.run.run);
  }
  const std::map<std::string, std::int64_t> origins = fleet::runs_by_origin(link);
  if (session.json)
    return print_json("fleet.status", {{"fleet", link.where()},
                                       {"store", session.db},
                                       {"ended_runs", ended.size()},
                                       {"waiting_runs", runs},
                                       {"waiting_frames", frames},
                                       {"waiting_remarks", remarks},
                                       {"fleet_runs", origins}});
  std::string counts;
  for (const auto& [origin, number] : origins)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", number, origin);
  tty::print("{}: schema {}; runs of all benches: {}\n{}: {}", link.where(), fleet::kFleetSchema,
             counts.empty() ? "none" : counts, session.db, backlog_text(ended.size(), runs, remarks, frames));
}

}  // namespace

void add_fleet_status(CLI::App& group, Session& session) {
  auto to = std::make_shared<std::string>();
  CLI::App* verb = group.add_subcommand("status", "what the fleet does not have yet");
  add_fleet_option(*verb, "--to", *to, session);
  verb->footer("Exit codes: 0 the server was reached, also if runs are waiting; 3 it was not; 5 it cannot store runs.");
  verb->callback([to, &session] { status(*to, session); });
}

// fleet runs, show, trend: the verbs of a store, on the facts of the fleet's runs, or on a copy of the runs that they
// need.

namespace {

using Json = nlohmann::ordered_json;

struct ReadOptions {
  std::string from, origin = "hardware", where, run;
};

// So that the runs of one origin are not mistaken for all runs.
void report_other_origins(fleet::Link& link, const ReadOptions& options, const Session& session) {
  if (session.json) return;
  for (const auto& [origin, runs] : fleet::runs_by_origin(link)) {
    if (origin != options.origin) tty::print(stderr, "{} {} left out (--origin {})\n", runs, origin, origin);
  }
}

// A run as listed, from its facts. Throws nlohmann::json::exception if they are invalid.
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
  FleetImport from(session, options.from);
  RunsList list(wanted, session);
  const std::vector<fleet::FleetRun> runs = fleet::find_runs(from.link(), options.origin, options.where);
  for (const fleet::FleetRun& run : runs) {
    try {
      const Json facts = analysis::parse_ordered_json(run.facts);
      const ListedRun listed = listed_run(run, facts);
      if (!wanted.sensor.empty() && listed.run.sensor_serial != wanted.sensor) continue;
      if (listed.run.started_utc < wanted.since || !list.takes(listed.run, listed.verdict)) continue;
      list.add(listed, session.json ? row_of(run, facts) : Json());
    } catch (const nlohmann::json::exception& error) {  // invalid facts of a bench hide only its own run
      tty::print(stderr, "warning: run {}, pushed by {}: its facts cannot be read: {}\n", run.run,
                 one_line(run.pushed_by), one_line(error.what()));
    }
  }
  list.end(!runs.empty());
  report_other_origins(from.link(), options, session);
}

// JSON output is a single document, so facts about the fleet are printed only as text.
void show_fleet(const ReadOptions& options, Session& session) {
  FleetImport from(session, options.from);
  const fleet::FleetRun run = fleet::find_run_by_name(from.link(), options.run);
  from.take({run});
  show_run(run.run, session);
  if (!session.json)
    tty::print("fleet {}: pushed by {} on {}, from {}\n", session.fleet, run.pushed_by, run.pushed_utc, run.source);
}

void trend_fleet(const ReadOptions& options, const TrendOptions& trend_options, Session& session) {
  FleetImport from(session, options.from);
  std::vector<fleet::FleetRun> runs;  // only runs with figures, because a list of all runs of a fleet is long
  for (fleet::FleetRun& run : fleet::find_runs(from.link(), options.origin, options.where)) {
    const nlohmann::json facts = analysis::try_json(run.facts);
    const bool has = facts.is_object() && facts.contains("figures") && !facts["figures"].empty();
    if (has && (trend_options.sensor.empty() || facts.value("sensor", nlohmann::json()) == trend_options.sensor))
      runs.push_back(std::move(run));
  }
  from.take({}, runs);
  report_other_origins(from.link(), options, session);
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
  verb.add_option("--origin", options.origin,
                  "runs of this origin; runs of different origins are never listed together")
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
  CLI::App* runs = add_reader(group, "runs", "one line per run of the fleet, as runs list", *options, session);
  add_choice(*runs, *options);
  add_runs_list_options(*runs, *list);
  runs->callback([options, list, &session] { list_fleet(*options, *list, session); });
  CLI::App* show =
      add_reader(group, "show", "everything stored about a run of the fleet, as runs show", *options, session);
  show->add_option("run", options->run, "the fleet's number of the run, or its UUID, or the beginning of the UUID")
      ->required();
  show->callback([options, &session] { show_fleet(*options, session); });
  CLI::App* over_time = add_reader(group, "trend", "figures of the fleet over time, as trend", *options, session);
  add_choice(*over_time, *options);
  add_trend_options(*over_time, *figures, session);
  over_time->callback([options, figures, &session] { trend_fleet(*options, *figures, session); });
}

}  // namespace tactbench::bench
