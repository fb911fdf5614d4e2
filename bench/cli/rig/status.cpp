// status, watch: what a live run does. Both only read: the run answers from its last published status, and its store is
// opened read-only.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/rig/named_run.h"
#include "bench/cli/session.h"
#include "bench/monitor/watch_run.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

namespace {

struct EndedRun {
  StoredRun run;
  std::optional<bool> carried_out;  // of one that has not ended
};

// The named run, else the store's last one of that bench; none: there is no store, or no run in it.
std::optional<EndedRun> run_of_store(const NamedRun& named, const Session& session) {
  if (named.run == 0 && !named.db_given && !std::filesystem::exists(session.db)) return std::nullopt;
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  std::int64_t number = named.run;
  const std::string bench = bench_id_of(named.bench);
  if (number == 0) {
    for (const db::RunRecord& run : store.runs())
      if (bench.empty() || run.bench_id == bench) number = run.run;
  }
  if (number == 0) return std::nullopt;
  EndedRun ended{stored_run(store, number), {}};
  if (ended.run.record.outcome == db::Outcome::kIncomplete) ended.carried_out = is_carried_out(store.path(), number);
  return ended;
}

void print_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) tty::print("{}\n", line);
}

void print_ended(const EndedRun& ended, const Session& session) {
  print_lines(stored_lines(ended.run, ended.carried_out));
  if (ended.carried_out != true) tty::print("next: {}\n", next_command(ended.run, session.db));
}

std::string denied_text(const LiveRun& live) {
  return fmt::format("a run on bench '{}' ({}) does not answer you: {}", live.bench, peer_text(live.server), live.text);
}

void print_status(const Candidates& found, const std::optional<EndedRun>& ended, const Session& session) {
  const char* between = "";
  for (const LiveRun& live : found.runs) {
    tty::print("{}", std::exchange(between, "\n"));
    print_lines(live.denied ? std::vector{denied_text(live)} : view_lines(view_of(live), session.unit()));
  }
  for (const SilentBench& silent : found.silent) tty::print("{}\n", silent_text(silent));
  if (!found.runs.empty()) return;
  if (found.silent.empty()) tty::print("no run is live\n");
  if (ended) {
    tty::print("last run in {}:\n", session.db);
    print_ended(*ended, session);
  } else {
    tty::print("no run in {}\n", session.db);
  }
}

void print_status_json(const Candidates& found, const std::optional<EndedRun>& ended) {
  nlohmann::ordered_json runs = nlohmann::ordered_json::array(), silent = runs;
  for (const LiveRun& live : found.runs) {
    if (!live.denied) {
      runs.push_back(view_json(view_of(live)));
    } else {
      silent.push_back({{"bench", live.bench}, {"run", 0}, {"process", live.server.process}, {"text", live.text}});
    }
  }
  for (const SilentBench& one : found.silent) {
    silent.push_back(
        {JSON_FIELDS(one, bench, run), {"process", one.server ? one.server->process : 0}, {"text", silent_text(one)}});
  }
  print_json("status", {{"live", !runs.empty()},
                        {"runs", runs},
                        {"silent", silent},
                        {"last_run", ended ? stored_json(ended->run, ended->carried_out) : nlohmann::ordered_json()}});
}

void show_status(const NamedRun& named, const Session& session) {
  const Candidates found = candidates(named, session);
  std::optional<EndedRun> ended;
  if (found.runs.empty()) ended = run_of_store(named, session);
  if (session.json) {
    print_status_json(found, ended);
  } else {
    print_status(found, ended, session);
  }
}

bool in_terminal() {
  const char* terminal = std::getenv("TERM");
  return ::isatty(STDOUT_FILENO) == 1 && terminal != nullptr && std::string(terminal) != "dumb";
}

// The run has ended already: says so, as at the end of a watch.
bool show_ended(const NamedRun& named, const Candidates& found, Session& session) {
  if (named.run == 0 || !found.runs.empty() || !found.silent.empty()) return false;
  const std::optional<EndedRun> ended = run_of_store(named, session);
  if (!ended || ended->carried_out == true) return false;
  print_ended(*ended, session);
  session.code = exit_code_of(ended->run.record);
  return true;
}

void watch_live(const NamedRun& named, Session& session) {
  const Candidates found = candidates(named, session);
  if (show_ended(named, found, session)) return;
  const LiveRun live = only_one(found, named, "status --watch", true);
  if (live.denied) refuse_word("TB-RUN-DENIED", denied_text(live), live.name, "watch it as one of these users");
  const StopRequest stop;
  WatchRunOptions options;
  options.terminal = in_terminal();
  options.shades = shades_of_terminal();
  options.unit = session.unit();
  const std::optional<StoredRun> ended = watch_run(live, options, stop);
  const std::string db = same_store(live.status.store, session.db) ? session.db : live.status.store;
  if (!ended) {
    tty::print(stderr, "{}no longer watched; run {} continues: `tactbench stop {}` ends it\n",
               options.terminal ? "\n" : "", live.status.run, live.status.run);
    return;
  }
  tty::print("next: {}\n", next_command(*ended, db));
  session.code = exit_code_of(ended->record);
}

}  // namespace

void add_status(CLI::App& app, Session& session) {
  auto named = std::make_shared<NamedRun>();
  auto follow = std::make_shared<bool>(false);
  CLI::App* verb = app.add_subcommand("status", "what live runs do; when none is live, how the last one ended");
  add_named_run(*verb, *named);
  verb->add_flag(
      "--watch", *follow,
      "follow it until it ends, with the array's last frame as a heat map; plain lines where standard output "
      "is no terminal. Ctrl-C ends the watching, not the run. The exit code is that of the run");
  verb->footer("Reads only. NO_COLOR=1 draws the heat map in characters.");
  verb->callback([named, follow, &session] {
    take_typed(*named, session);
    if (*follow && session.json)
      throw Error("TB-USAGE", "what --watch draws is no JSON", "--json", "leave --watch or --json out");
    *follow ? watch_live(*named, session) : show_status(*named, session);
  });
}

}  // namespace tactbench::bench
