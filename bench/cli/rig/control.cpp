// pause, resume, stop, abort, panic: commands to a live run on this machine; `resume` opens a run again whose process
// has ended.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/rig/named_run.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/machine_name.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct ControlOptions : NamedRun {  // bench of `resume`: a file
  std::string on_event;
  bool assume_yes = false, abort = false;
};

// The answer of the run that took the command; throws when it did not.
LiveRun taken_by(const LiveRun& chosen, Command command) {
  std::optional<LiveRun> answer = send_command(chosen.name, command, chosen.server);
  if (!answer) {
    refuse_word("TB-RUN-NOT-LIVE", fmt::format("run {} no longer answers", chosen.status.run), shown_name(chosen.name),
                fmt::format("see `tactbench runs show {} --db {}`", chosen.status.run, chosen.status.store));
  }
  if (answer->denied) {
    refuse_word("TB-RUN-DENIED", fmt::format("the run on bench '{}': {}", answer->bench, answer->text),
                shown_name(chosen.name), "give the command as one of these users");
  }
  if (!answer->taken) {
    refuse_word("TB-RUN-WORD", answer->text, shown_name(chosen.name), "see `tactbench runs list`");
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

void say(const ControlOptions& options, const Session& session, Command command, const Candidates& found) {
  const bool named = !options.bench.empty() || options.db_given || options.run != 0;
  const bool all = command == Command::kPanic && named && found.runs.size() > 1;
  const std::optional<LiveRun> chosen =
      all ? std::nullopt : std::optional(only_one(found, options, to_string(command), command == Command::kPanic));
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
      refuse_word("TB-RUN-NOT-LIVE", "no run is live", session.db,
                  fmt::format("the last one that did not complete: tactbench resume {}", open->run));
  }
  // A number alone must not resume a run of another store when this store's was meant.
  const bool ours = std::any_of(found.runs.begin(), found.runs.end(),
                                [&](const LiveRun& run) { return same_store(run.status.store, session.db); });
  if (options.run != 0 && !options.db_given && !ours && std::filesystem::exists(session.db)) {
    refuse_word(
        "TB-RUN-AMBIGUOUS", fmt::format("a live run {} belongs to another store than '{}'", options.run, session.db),
        "runs listed in /proc/net/unix as " + shown_name(""),
        fmt::format("name its store: tactbench resume {} --db STORE; live: {}", options.run, listed(found.runs)));
  }
  say(options, session, Command::kResume, found);
}

}  // namespace

void add_control(CLI::App& app, Session& session) {
  const auto add = [&](Command command, const char* what) {
    auto options = std::make_shared<ControlOptions>();
    CLI::App* verb = app.add_subcommand(to_string(command), what);
    add_named_run(*verb, *options);
    if (command == Command::kStop)
      verb->add_flag("--abort", options->abort, "something seems wrong: the run's outcome is aborted, not stopped");
    if (command == Command::kResume) {
      verb->add_option("--on-event", options->on_event,
                       "shell command for the events done, failed, waiting (see run --help)");
      verb->add_flag("--yes", options->assume_yes, "answer operator prompts with yes");
    }
    verb->callback([options, &session, command] {
      take_typed(*options, session);
      if (command == Command::kResume) return resume(*options, session);
      say(*options, session, options->abort ? Command::kAbort : command, candidates(*options, session));
    });
  };
  add(Command::kPause, "pause at the end of the branch: vented, retracted (as Ctrl-C once)");
  add(Command::kResume,
      "continue a paused run, or open an ended one again\n"
      "Of an interrupted or ended run the sensor is conditioned and the interrupted branch repeated from its turning "
      "point; the incomplete one is kept as void. --bench: another bench file than the stored one.");
  add(Command::kStop, "end a run now: vents, retracts, proves the safe state (as Ctrl-C twice)");
  add(Command::kPanic,
      "vent and halt at once, past the sequencer; latches a trip\n"
      "It goes over the dead-man's own connection; outcome aborted. Not an emergency stop: that is a switch that takes "
      "air and power away.");
}

}  // namespace tactbench::bench
