// pause, resume, stop, abort, panic: words to a live run through its control socket; resume of a dead one opens it
// again.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/run.h"
#include "bench/cli/session.h"
#include "bench/run/control_socket.h"
#include "bench/run/locks.h"

namespace tactbench::bench {

namespace {

struct ControlOptions {
  std::int64_t run = 0;
  bool db_given = false;
  std::string bench, on_event;
  bool assume_yes = false;
};

bool same_store(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored);
}

std::vector<LiveRun> matching(const ControlOptions& options, const Session& session) {
  std::vector<LiveRun> found;
  for (const LiveRun& live : live_runs()) {
    if (options.run != 0 && live.status.run != options.run) continue;
    if (options.db_given && !same_store(live.status.store, session.db)) continue;
    found.push_back(live);
  }
  return found;
}

std::string listed(const std::vector<LiveRun>& runs) {
  std::vector<std::string> lines;
  for (const LiveRun& live : runs) {
    lines.push_back(fmt::format("run {} of {} on bench '{}' ({}, step {}/{})", live.status.run, live.status.store,
                                live.bench, to_string(live.status.state), live.status.step, live.status.steps));
  }
  return fmt::format("{}", fmt::join(lines, "; "));
}

LiveRun only(const std::vector<LiveRun>& found, const ControlOptions& options, Word word) {
  if (found.size() == 1) return found.front();
  const std::vector<LiveRun> all = live_runs();
  if (found.empty()) {
    throw Error(ExitCode::kUsage, "TB-RUN-NOT-LIVE",
                options.run != 0 ? fmt::format("no live run {} answers", options.run) : "no live run answers",
                "control sockets in " + runtime_folder(),
                all.empty()
                    ? "see `tactbench runs list`; a run that has ended is gone on with by `tactbench resume RUN`"
                    : "live: " + listed(all));
  }
  throw Error(ExitCode::kUsage, "TB-RUN-AMBIGUOUS", fmt::format("{} live runs answer", found.size()),
              "control sockets in " + runtime_folder(),
              fmt::format("say which: tactbench {} RUN --db STORE; live: {}", to_string(word), listed(found)));
}

void say(const ControlOptions& options, const Session& session, Word word) {
  const LiveRun chosen = only(matching(options, session), options, word);
  const std::optional<LiveRun> answer = send_word(chosen.socket, word);
  if (!answer) {
    throw Error(ExitCode::kUsage, "TB-RUN-NOT-LIVE", fmt::format("run {} does not answer any more", chosen.status.run),
                chosen.socket, "see `tactbench runs show " + std::to_string(chosen.status.run) + "`");
  }
  if (!answer->taken) {
    throw Error(ExitCode::kUsage, "TB-RUN-WORD", answer->text, chosen.socket, "see `tactbench runs list`");
  }
  if (session.json) {
    print_json(to_string(word), {{"run", answer->status.run},
                                 {"store", answer->status.store},
                                 {"state", to_string(answer->status.state)},
                                 {"step", answer->status.step},
                                 {"steps", answer->status.steps},
                                 {"answer", answer->text}});
  } else {
    fmt::print("{}\n", answer->text);
  }
}

void resume(const ControlOptions& options, Session& session) {
  const std::vector<LiveRun> live = matching(options, session);
  if (live.empty() && options.run != 0) {
    return resume_run(options.run, {options.bench, options.on_event, options.assume_yes}, session);
  }
  // A number alone must not wake a run of another store when this one's was meant.
  const bool ours = std::any_of(live.begin(), live.end(),
                                [&](const LiveRun& run) { return same_store(run.status.store, session.db); });
  if (options.run != 0 && !options.db_given && !ours && std::filesystem::exists(session.db)) {
    throw Error(ExitCode::kUsage, "TB-RUN-AMBIGUOUS",
                fmt::format("a run {} is live, but of another store than '{}'", options.run, session.db),
                "control sockets in " + runtime_folder(),
                fmt::format("say which: tactbench resume {} --db STORE; live: {}", options.run, listed(live)));
  }
  say(options, session, Word::kResume);
}

CLI::App* add_word(CLI::App& app, Session& session, const std::shared_ptr<ControlOptions>& options, Word word,
                   const char* what) {
  CLI::App* verb = app.add_subcommand(to_string(word), what);
  verb->add_option("run", options->run, "its number; may be left out where one run is live");
  verb->add_option("--db", session.db, "run store, one SQLite file a bench")->each([options](const std::string&) {
    options->db_given = true;
  });
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->add_flag("-q,--quiet", session.quiet, "no progress line");
  return verb;
}

}  // namespace

void add_control(CLI::App& app, Session& session) {
  const auto plain = [&](Word word, const char* what) {
    auto options = std::make_shared<ControlOptions>();
    CLI::App* verb = add_word(app, session, options, word, what);
    verb->callback([options, &session, word] { say(*options, session, word); });
  };
  plain(Word::kPause,
        "a live run goes on to the end of its branch, vents, retracts and waits (as Ctrl-C once); state paused");
  auto options = std::make_shared<ControlOptions>();
  CLI::App* verb = add_word(app, session, options, Word::kResume,
                            "a paused run goes on; a run that died or was ended is opened again: conditioned, the "
                            "interrupted branch done again from its turning point, the half one kept as void");
  verb->add_option("--bench", options->bench, "bench file, for a run that has ended; without it the stored one");
  verb->add_option("--on-event", options->on_event, "command told of done, failed, waiting (see run --help)");
  verb->add_flag("--yes", options->assume_yes, "operator prompts answer themselves");
  verb->callback([options, &session] { resume(*options, session); });
  plain(Word::kStop, "a live run ends now: vents, retracts, proves it; outcome stopped (as Ctrl-C twice)");
  plain(Word::kAbort, "as stop, for when something looked wrong; outcome aborted");
  plain(
      Word::kPanic,
      "vents and halts at once, past the sequencer, over the dead-man's own connection, which latches a trip; outcome "
      "aborted. Not an emergency stop: that is a switch that takes air and power away");
}

}  // namespace tactbench::bench
