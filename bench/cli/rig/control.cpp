// pause, resume, stop, abort, panic: commands to a live run on this machine; `resume` reopens a run whose process has
// ended.
#include "bench/cli/rig/control.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/monitor/run_view.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct ControlOptions : LiveRunSelector {  // bench of `resume`: a file
  std::string on_event;
  bool assume_yes = false, abort = false;
};

[[noreturn]] void refuse_command(ErrorId id, const std::string& what, const std::string& name,
                                 const std::string& remedy) {
  throw Error(id, what, name, remedy);
}

// The answer of the run that took the command; throws when it did not.
LiveRun taken_by(const LiveRun& chosen, Command command) {
  std::optional<LiveRun> answer = send_command(chosen.name, command, chosen.server);
  if (!answer) {
    refuse_command("TB-RUN-NOT-LIVE", fmt::format("run {} no longer answers", chosen.status.run),
                   shown_name(chosen.name),
                   fmt::format("see `tactbench runs show {} --db {}`", chosen.status.run, chosen.status.store));
  }
  if (answer->denied) {
    refuse_command("TB-RUN-DENIED", fmt::format("the run on bench '{}': {}", answer->bench, answer->text),
                   shown_name(chosen.name), "give the command as one of these users");
  }
  if (!answer->taken) {
    refuse_command("TB-RUN-WORD", answer->text, shown_name(chosen.name), "see `tactbench runs list`");
  }
  return *std::move(answer);
}

// Several may answer to the named bench or run, some of which may only hold the name: sends the command to each.
LiveRun panic_all(const std::vector<LiveRun>& runs) {
  std::optional<LiveRun> taken;
  std::optional<Error> refused;
  for (const LiveRun& live : runs) {
    try {
      taken = taken_by(live, Command::kPanic);
    } catch (const Error& error) {
      refused = error;
      tty::print(stderr, "warning: {}\n", error.what());
    }
  }
  if (!taken) throw Error(*refused);
  return *taken;
}

std::string run_text(const LiveRun& live) {
  if (live.denied) return fmt::format("a run on bench '{}' ({})", live.bench, peer_text(live.server));
  return fmt::format("run {} of {} on bench '{}' ({}, step {}/{})", live.status.run, live.status.store, live.bench,
                     to_string(live.status.state), live.status.step, live.status.steps);
}

// Whether it did not answer. Root queries all users' processes, so for root a process without a false claim did not
// answer.
bool unheard(const SilentBench& silent) { return silent.stranger && (silent.lied || ::geteuid() != 0); }

std::string silent_text(const SilentBench& silent) {
  const std::string who = silent.server ? fmt::format(" ({})", peer_text(*silent.server)) : std::string();
  if (unheard(silent)) return fmt::format("bench '{}' is held by another user{}", silent.bench, who);
  const std::string run = silent.run != 0 ? fmt::format("run {}", silent.run) : std::string("what holds the lock");
  return fmt::format("{} on bench '{}' does not answer{}", run, silent.bench, who);
}

void say(const ControlOptions& options, const Session& session, Command command, const Candidates& found) {
  const bool named = !options.bench.empty() || options.db_given || options.run != 0;
  const bool all = command == Command::kPanic && named && found.runs.size() > 1;
  const std::optional<LiveRun> chosen =
      all ? std::nullopt
          : std::optional(require_single_run(found, options, to_string(command), command == Command::kPanic));
  for (const SilentBench& silent : found.silent)
    if (!silent.stranger) tty::print(stderr, "warning: {}\n", silent_text(silent));
  const LiveRun answer = all ? panic_all(found.runs) : taken_by(*chosen, command);
  if (session.json) {
    print_json(to_string(command), {{"run", answer.status.run},
                                    {"bench", answer.bench},
                                    {"store", answer.status.store},
                                    {"state", to_string(answer.status.state)},
                                    JSON_FIELDS(answer.status, step, steps),
                                    {"answer", answer.text},
                                    {"by", peer_text(answer.server)}});
  } else {
    tty::print("{} (answered by {})\n", answer.text, peer_text(answer.server));
  }
}

void resume(const ControlOptions& options, Session& session) {
  Candidates found = candidates(options, session);
  if (options.run != 0) std::erase_if(found.runs, [](const LiveRun& live) { return live.denied; });  // another's
  // A bench that does not answer may carry out this very run; the run's own lock shows that.
  if (found.runs.empty() && options.run != 0) {
    return resume_run(options.run, {options.bench, options.on_event, options.assume_yes}, session);
  }
  if (found.runs.empty() && found.others.empty() && found.silent.empty() && std::filesystem::exists(session.db)) {
    const std::vector<db::RunRecord> runs = db::RunStore::open_read_only(session.db).runs();
    const auto open = std::find_if(runs.rbegin(), runs.rend(), [](const db::RunRecord& run) {
      return run.outcome != db::Outcome::kCompleted && !run.is_void() && run.origin != "imported";
    });
    if (open != runs.rend())
      refuse_command("TB-RUN-NOT-LIVE", "no run is live", session.db,
                     fmt::format("the last one that did not complete: tactbench resume {}", open->run));
  }
  // A number alone must not resume a run of another store when this store's was meant.
  const bool ours = std::any_of(found.runs.begin(), found.runs.end(),
                                [&](const LiveRun& run) { return same_store(run.status.store, session.db); });
  if (options.run != 0 && !options.db_given && !ours && std::filesystem::exists(session.db)) {
    refuse_command(
        "TB-RUN-AMBIGUOUS", fmt::format("a live run {} belongs to another store than '{}'", options.run, session.db),
        "runs listed in /proc/net/unix as " + shown_name(""),
        fmt::format("name its store: tactbench resume {} --db STORE; live: {}", options.run, listed(found.runs)));
  }
  say(options, session, Command::kResume, found);
}

void add_named_run(CLI::App& verb, LiveRunSelector& named) {
  verb.add_option("run", named.run, "its number; may be omitted when one run is live");
}

// Uses --db and --bench only as typed: no file may redirect a command to another run.
void use_typed_options(LiveRunSelector& named, const Session& session) {
  named.db_given = session.typed("--db");
  named.bench = session.typed_bench();
}

}  // namespace

void add_control(CLI::App& app, Session& session) {
  const auto add = [&](Command command, const char* what) {
    auto options = std::make_shared<ControlOptions>();
    CLI::App* verb = app.add_subcommand(to_string(command), what);
    add_named_run(*verb, *options);
    if (command == Command::kStop)
      verb->add_flag("--abort", options->abort,
                     "end a run because something seems wrong: its outcome is aborted, not stopped");
    if (command == Command::kResume) {
      verb->add_option("--on-event", options->on_event,
                       "shell command for the events done, failed, waiting (see run --help)");
      verb->add_flag("--yes", options->assume_yes, "answer operator prompts with yes");
    }
    verb->callback([options, &session, command] {
      use_typed_options(*options, session);
      if (command == Command::kResume) return resume(*options, session);
      say(*options, session, options->abort ? Command::kAbort : command, candidates(*options, session));
    });
  };
  add(Command::kPause, "pause at the end of the branch: vented, retracted (as Ctrl-C once)");
  add(Command::kResume,
      "continue a paused run, or reopen an ended one\n"
      "For an interrupted or ended run the sensor is conditioned and the interrupted branch is repeated from its "
      "turning point; the incomplete one is kept as void. --bench: another bench file than the stored one.");
  add(Command::kStop, "end a run now: vents, retracts, proves the safe state (as Ctrl-C twice)");
  add(Command::kPanic,
      "vent and halt immediately, without the sequencer; latches a trip\n"
      "It uses the dead-man's own connection; the outcome is aborted. Not an emergency stop: that is a switch that "
      "cuts off air and power.");
}

std::string bench_id_of(const std::string& bench) {
  return bench.ends_with(".toml") ? read_bench(find_config(bench), {}).id : bench;
}

bool same_store(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored);
}

Candidates candidates(const LiveRunSelector& named, const Session& session) {
  const auto meant = [&](const LiveRun& live) {
    return (named.run == 0 || live.status.run == named.run) &&
           (!named.db_given || same_store(live.status.store, session.db));
  };
  ListenOptions listen;
  listen.wanted = meant;
  if (named.run != 0 && named.db_given) listen.enough = meant;  // there can be no second one
  RunReplies heard = send_to_runs(run_names(bench_id_of(named.bench)), Command::kStatus, listen);
  Candidates found;
  for (LiveRun& live : heard.answers) (live.denied || meant(live) ? found.runs : found.others).push_back(live);
  // Prefers runs of trusted users, and runs that accept commands of this user: others may only hold the name.
  const auto prefer = [&](const auto& good) {
    if (std::any_of(found.runs.begin(), found.runs.end(), good)) std::erase_if(found.runs, std::not_fn(good));
  };
  prefer([](const LiveRun& live) { return is_trusted(live.server, ::geteuid()); });
  prefer([](const LiveRun& live) { return !live.denied; });
  for (const SilentBench& silent : heard.silent) {
    const bool other_run = named.run != 0 && silent.run != 0 && silent.run != named.run;
    if (!other_run) found.silent.push_back(silent);
  }
  std::ranges::stable_partition(found.silent, std::not_fn(&SilentBench::stranger));
  return found;
}

std::string listed(const std::vector<LiveRun>& runs, const std::vector<SilentBench>& silent) {
  std::vector<std::string> lines;
  for (const LiveRun& live : runs) lines.push_back(run_text(live));
  for (const SilentBench& one : silent) lines.push_back(silent_text(one));
  return fmt::format("{}", fmt::join(lines, "; "));
}

[[noreturn]] void refuse_silent(const std::vector<SilentBench>& silent) {
  const SilentBench& first = silent.front();
  if (unheard(first)) {
    refuse_command(
        "TB-RUN-DENIED",
        fmt::format("{}: it does not belong to root, your own user or a member of the group '{}'{}", listed({}, silent),
                    kGroupName, first.lied ? ", and does not carry out a run of the store that it names" : ""),
        shown_name(first.name),
        first.lied
            ? fmt::format("nothing was sent to it: check the rig; `kill {}` ends that process", first.server->process)
            : fmt::format("contact that user, or give the command as root; members of the group '{}' may command each "
                          "other's runs",
                          kGroupName));
  }
  const std::string process = first.server ? std::to_string(first.server->process) : "PID";
  refuse_command(
      "TB-RUN-SILENT", listed({}, silent), shown_name(first.name),
      fmt::format("check the rig: the process is stopped, or is opening its devices. `kill -CONT {0}` continues a "
                  "stopped process, `kill -KILL {0}` ends it, and its dead-man vents",
                  process));
}

LiveRun require_single_run(const Candidates& found, const LiveRunSelector& named, const std::string& verb,
                           bool urgent) {
  const std::string place = "runs listed in /proc/net/unix as " + shown_name("");
  // In an emergency the command goes to every run that answers. Any other command could end or resume the wrong run.
  const bool exact = !named.bench.empty() || named.db_given || urgent;
  if (found.runs.size() == 1 && (exact || std::all_of(found.silent.begin(), found.silent.end(),
                                                      [](const SilentBench& one) { return one.stranger; }))) {
    return found.runs.front();
  }
  if (!found.runs.empty()) {
    refuse_command("TB-RUN-AMBIGUOUS", fmt::format("{} runs are live", found.runs.size() + found.silent.size()), place,
                   fmt::format("name one: tactbench {} --bench ID, or RUN --db STORE; live: {}", verb,
                               listed(found.runs, found.silent)));
  }
  if (!found.silent.empty()) refuse_silent(found.silent);
  refuse_command("TB-RUN-NOT-LIVE",
                 named.run != 0 ? fmt::format("no live run {} answers", named.run) : "no live run answers", place,
                 found.others.empty() ? "see `tactbench runs list`; continue an ended run with `tactbench resume RUN`"
                                      : "live: " + listed(found.others));
}

// status, watch: what a live run does. Both only read: the run answers from its last published status, and its store is
// opened read-only.

namespace {

struct EndedRun {
  StoredRun run;
  std::optional<bool> carried_out;  // of one that has not ended
};

// The named run, else the store's last one of that bench; none: there is no store, or no run in it.
std::optional<EndedRun> run_of_store(const LiveRunSelector& named, const Session& session) {
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

void show_status(const LiveRunSelector& named, const Session& session) {
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
bool show_ended(const LiveRunSelector& named, const Candidates& found, Session& session) {
  if (named.run == 0 || !found.runs.empty() || !found.silent.empty()) return false;
  const std::optional<EndedRun> ended = run_of_store(named, session);
  if (!ended || ended->carried_out == true) return false;
  print_ended(*ended, session);
  session.code = exit_code_of(ended->run.record);
  return true;
}

void watch_live(const LiveRunSelector& named, Session& session) {
  const Candidates found = candidates(named, session);
  if (show_ended(named, found, session)) return;
  const LiveRun live = require_single_run(found, named, "status --watch", true);
  if (live.denied) refuse_command("TB-RUN-DENIED", denied_text(live), live.name, "watch it as one of these users");
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
  auto named = std::make_shared<LiveRunSelector>();
  auto follow = std::make_shared<bool>(false);
  CLI::App* verb = app.add_subcommand("status", "show what live runs do or, if none is live, how the last one ended");
  add_named_run(*verb, *named);
  verb->add_flag("--watch", *follow,
                 "follow it until it ends, with the array's last frame as a heat map; plain lines if standard output "
                 "is not a terminal. Ctrl-C ends the watching, not the run. The exit code is that of the run");
  verb->footer("Read-only. NO_COLOR=1 draws the heat map in characters.");
  verb->callback([named, follow, &session] {
    use_typed_options(*named, session);
    if (*follow && session.json)
      throw Error("TB-USAGE", "--watch draws, which is not possible as JSON", "--json", "leave --watch or --json out");
    *follow ? watch_live(*named, session) : show_status(*named, session);
  });
}

}  // namespace tactbench::bench
