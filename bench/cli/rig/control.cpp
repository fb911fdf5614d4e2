// pause, resume, stop, abort, panic: commands to a live run on this machine; `resume` opens a run again whose process
// has ended.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/machine_name.h"

namespace tactbench::bench {

namespace {

struct ControlOptions {
  std::int64_t run = 0;
  bool db_given = false;
  std::string bench;  // an id, or a bench file; of `resume`: a file
  std::string on_event;
  bool assume_yes = false;
};

bool same_store(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored);
}

std::string bench_id_of(const std::string& named) {
  return named.ends_with(".toml") ? read_bench(find_config(named), {}).id : named;
}

// The live runs of this machine that could be meant.
struct Candidates {
  std::vector<LiveRun> runs, others;  // runs that answer: meant; not meant
  std::vector<SilentBench> silent;    // benches that do not answer and could be meant
};

Candidates candidates(const ControlOptions& options, const Session& session) {
  const auto meant = [&](const LiveRun& live) {
    return (options.run == 0 || live.status.run == options.run) &&
           (!options.db_given || same_store(live.status.store, session.db));
  };
  ListenOptions listen;
  listen.wanted = meant;
  if (options.run != 0 && options.db_given) listen.enough = meant;  // there can be no second one
  Heard heard = say_to(run_names(bench_id_of(options.bench)), Command::kStatus, listen);
  Candidates found;
  for (LiveRun& live : heard.answers) (live.denied || meant(live) ? found.runs : found.others).push_back(live);
  // Prefers runs of trusted users, and runs that accept commands of this user: others may only hold the name.
  const auto prefer = [&](const auto& good) {
    if (std::any_of(found.runs.begin(), found.runs.end(), good)) std::erase_if(found.runs, std::not_fn(good));
  };
  prefer([](const LiveRun& live) { return is_trusted(live.server, ::geteuid()); });
  prefer([](const LiveRun& live) { return !live.denied; });
  for (const SilentBench& silent : heard.silent) {
    const bool other_run = options.run != 0 && silent.run != 0 && silent.run != options.run;
    if (!other_run) found.silent.push_back(silent);
  }
  return found;
}

std::string run_text(const LiveRun& live) {
  if (live.denied) return fmt::format("a run on bench '{}' ({})", live.bench, peer_text(live.server));
  return fmt::format("run {} of {} on bench '{}' ({}, step {}/{})", live.status.run, live.status.store, live.bench,
                     to_string(live.status.state), live.status.step, live.status.steps);
}

// In words; root accepts all users, so for root it did not answer at all.
bool unheard(const SilentBench& silent) { return silent.stranger && ::geteuid() != 0; }

std::string silent_text(const SilentBench& silent) {
  const std::string who = silent.server ? fmt::format(" ({})", peer_text(*silent.server)) : std::string();
  if (unheard(silent)) return fmt::format("bench '{}' is held by another user{}", silent.bench, who);
  const std::string run = silent.run != 0 ? fmt::format("run {}", silent.run) : std::string("what holds the lock");
  return fmt::format("{} on bench '{}' does not answer{}", run, silent.bench, who);
}

std::string listed(const std::vector<LiveRun>& runs, const std::vector<SilentBench>& silent = {}) {
  std::vector<std::string> lines;
  for (const LiveRun& live : runs) lines.push_back(run_text(live));
  for (const SilentBench& one : silent) lines.push_back(silent_text(one));
  return fmt::format("{}", fmt::join(lines, "; "));
}

[[noreturn]] void refuse_word(const std::string& id, const std::string& what, const std::string& name,
                              const std::string& remedy) {
  throw Error(ExitCode::kUsage, id, what, name, remedy);
}

[[noreturn]] void refuse_silent(const std::vector<SilentBench>& silent) {
  const SilentBench& first = silent.front();
  if (unheard(first)) {
    refuse_word(
        "TB-RUN-DENIED",
        fmt::format("{}: neither root, nor your own user, nor of the group '{}'", listed({}, silent), kGroupName),
        shown_name(first.name),
        fmt::format(
            "ask that user, or give the command as root; members of the group '{}' may command each other's runs",
            kGroupName));
  }
  const std::string process = first.server ? std::to_string(first.server->process) : "PID";
  refuse_word("TB-RUN-SILENT", listed({}, silent), shown_name(first.name),
              fmt::format("check the rig: the process is stopped, or opens its devices. `kill -CONT {0}` continues a "
                          "stopped process, `kill -KILL {0}` ends it, and its dead-man vents",
                          process));
}

LiveRun only(const Candidates& found, const ControlOptions& options, Command command) {
  const std::string place = "runs listed in /proc/net/unix as " + shown_name("");
  // In an emergency the command goes to every run that answers. Any other command could end or resume the wrong run.
  const bool exact = !options.bench.empty() || options.db_given || command == Command::kPanic;
  if (found.runs.size() == 1 && (exact || std::all_of(found.silent.begin(), found.silent.end(),
                                                      [](const SilentBench& one) { return one.stranger; }))) {
    return found.runs.front();
  }
  if (!found.runs.empty()) {
    refuse_word("TB-RUN-AMBIGUOUS", fmt::format("{} runs are live", found.runs.size() + found.silent.size()), place,
                fmt::format("name one: tactbench {} --bench ID, or RUN --db STORE; live: {}", to_string(command),
                            listed(found.runs, found.silent)));
  }
  if (!found.silent.empty()) refuse_silent(found.silent);
  refuse_word("TB-RUN-NOT-LIVE",
              options.run != 0 ? fmt::format("no live run {} answers", options.run) : "no live run answers", place,
              found.others.empty() ? "see `tactbench runs list`; continue an ended run with `tactbench resume RUN`"
                                   : "live: " + listed(found.others));
}

// The answer of the run that took the command; throws when it did not.
LiveRun taken_by(const LiveRun& chosen, Command command) {
  std::optional<LiveRun> answer = send_command(chosen.name, command);
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
  const std::optional<LiveRun> chosen = all ? std::nullopt : std::optional(only(found, options, command));
  for (const SilentBench& silent : found.silent)
    if (!silent.stranger) tty::print(stderr, "warning: {}\n", silent_text(silent));
  const LiveRun answer = all ? panic_all(found.runs) : taken_by(*chosen, command);
  if (session.json) {
    print_json(to_string(command), {{"run", answer.status.run},
                                    {"bench", answer.bench},
                                    {"store", answer.status.store},
                                    {"state", to_string(answer.status.state)},
                                    {"step", answer.status.step},
                                    {"steps", answer.status.steps},
                                    {"answer", answer.text}});
  } else {
    tty::print("{}\n", answer.text);
  }
}

void resume(const ControlOptions& options, Session& session) {
  Candidates found = candidates(options, session);
  if (options.run != 0) std::erase_if(found.runs, [](const LiveRun& live) { return live.denied; });  // another's
  // A bench that does not answer may carry out this very run; the run's own lock shows that.
  if (found.runs.empty() && options.run != 0) {
    return resume_run(options.run, {options.bench, options.on_event, options.assume_yes}, session);
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

CLI::App* add_command(CLI::App& app, Session& session, const std::shared_ptr<ControlOptions>& options, Command command,
                      const char* what) {
  CLI::App* verb = app.add_subcommand(to_string(command), what);
  verb->add_option("run", options->run, "its number; may be omitted when one run is live");
  verb->add_option("--db", session.db, "run store, one SQLite file per bench")->each([options](const std::string&) {
    options->db_given = true;
  });
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->add_flag("-q,--quiet", session.quiet, "no progress line");
  return verb;
}

}  // namespace

void add_control(CLI::App& app, Session& session) {
  const auto plain = [&](Command command, const char* what) {
    auto options = std::make_shared<ControlOptions>();
    CLI::App* verb = add_command(app, session, options, command, what);
    verb->add_option("--bench", options->bench, "id of the bench, or its bench file; only this bench is queried");
    verb->callback([options, &session, command] { say(*options, session, command, candidates(*options, session)); });
  };
  plain(Command::kPause,
        "a live run continues to the end of its branch, vents, retracts and waits (as Ctrl-C once); state paused");
  auto options = std::make_shared<ControlOptions>();
  CLI::App* verb =
      add_command(app, session, options, Command::kResume,
                  "a paused run continues; an interrupted or ended run is opened again: the sensor is conditioned and "
                  "the interrupted branch repeated from its turning point; the incomplete one is kept as void");
  verb->add_option("--bench", options->bench, "bench file, for a run that has ended; without it the stored one");
  verb->add_option("--on-event", options->on_event,
                   "shell command for the events done, failed, waiting (see run --help)");
  verb->add_flag("--yes", options->assume_yes, "answer operator prompts with yes");
  verb->callback([options, &session] { resume(*options, session); });
  plain(Command::kStop,
        "a live run ends now: vents, retracts, proves the safe state; outcome stopped (as Ctrl-C twice)");
  plain(Command::kAbort, "as stop, for when something looked wrong; outcome aborted");
  plain(
      Command::kPanic,
      "vents and halts at once, past the sequencer, over the dead-man's own connection, which latches a trip; outcome "
      "aborted. Not an emergency stop: that is a switch that takes air and power away");
}

}  // namespace tactbench::bench
