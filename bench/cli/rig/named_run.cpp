#include "bench/cli/rig/named_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>

#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/run/control/machine_name.h"

namespace tactbench::bench {

namespace {

std::string run_text(const LiveRun& live) {
  if (live.denied) return fmt::format("a run on bench '{}' ({})", live.bench, peer_text(live.server));
  return fmt::format("run {} of {} on bench '{}' ({}, step {}/{})", live.status.run, live.status.store, live.bench,
                     to_string(live.status.state), live.status.step, live.status.steps);
}

// In words; root asks all users, so for root one that told no lie did not answer at all.
bool unheard(const SilentBench& silent) { return silent.stranger && (silent.lied || ::geteuid() != 0); }

}  // namespace

std::string bench_id_of(const std::string& bench) {
  return bench.ends_with(".toml") ? read_bench(find_config(bench), {}).id : bench;
}

bool same_store(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored);
}

Candidates candidates(const NamedRun& named, const Session& session) {
  const auto meant = [&](const LiveRun& live) {
    return (named.run == 0 || live.status.run == named.run) &&
           (!named.db_given || same_store(live.status.store, session.db));
  };
  ListenOptions listen;
  listen.wanted = meant;
  if (named.run != 0 && named.db_given) listen.enough = meant;  // there can be no second one
  Heard heard = say_to(run_names(bench_id_of(named.bench)), Command::kStatus, listen);
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

std::string silent_text(const SilentBench& silent) {
  const std::string who = silent.server ? fmt::format(" ({})", peer_text(*silent.server)) : std::string();
  if (unheard(silent)) return fmt::format("bench '{}' is held by another user{}", silent.bench, who);
  const std::string run = silent.run != 0 ? fmt::format("run {}", silent.run) : std::string("what holds the lock");
  return fmt::format("{} on bench '{}' does not answer{}", run, silent.bench, who);
}

std::string listed(const std::vector<LiveRun>& runs, const std::vector<SilentBench>& silent) {
  std::vector<std::string> lines;
  for (const LiveRun& live : runs) lines.push_back(run_text(live));
  for (const SilentBench& one : silent) lines.push_back(silent_text(one));
  return fmt::format("{}", fmt::join(lines, "; "));
}

[[noreturn]] void refuse_word(ErrorId id, const std::string& what, const std::string& name, const std::string& remedy) {
  throw Error(id, what, name, remedy);
}

[[noreturn]] void refuse_silent(const std::vector<SilentBench>& silent) {
  const SilentBench& first = silent.front();
  if (unheard(first)) {
    refuse_word("TB-RUN-DENIED",
                fmt::format("{}: neither root, nor your own user, nor of the group '{}'{}", listed({}, silent),
                            kGroupName, first.lied ? ", nor at work on a run of the store that it names" : ""),
                shown_name(first.name),
                first.lied
                    ? fmt::format("nothing was commanded by it: look at the rig; `kill {}` ends that process",
                                  first.server->process)
                    : fmt::format("ask that user, or give the command as root; members of the group '{}' may command "
                                  "each other's runs",
                                  kGroupName));
  }
  const std::string process = first.server ? std::to_string(first.server->process) : "PID";
  refuse_word("TB-RUN-SILENT", listed({}, silent), shown_name(first.name),
              fmt::format("check the rig: the process is stopped, or opens its devices. `kill -CONT {0}` continues a "
                          "stopped process, `kill -KILL {0}` ends it, and its dead-man vents",
                          process));
}

LiveRun only_one(const Candidates& found, const NamedRun& named, const std::string& verb, bool urgent) {
  const std::string place = "runs listed in /proc/net/unix as " + shown_name("");
  // In an emergency the command goes to every run that answers. Any other command could end or resume the wrong run.
  const bool exact = !named.bench.empty() || named.db_given || urgent;
  if (found.runs.size() == 1 && (exact || std::all_of(found.silent.begin(), found.silent.end(),
                                                      [](const SilentBench& one) { return one.stranger; }))) {
    return found.runs.front();
  }
  if (!found.runs.empty()) {
    refuse_word("TB-RUN-AMBIGUOUS", fmt::format("{} runs are live", found.runs.size() + found.silent.size()), place,
                fmt::format("name one: tactbench {} --bench ID, or RUN --db STORE; live: {}", verb,
                            listed(found.runs, found.silent)));
  }
  if (!found.silent.empty()) refuse_silent(found.silent);
  refuse_word("TB-RUN-NOT-LIVE",
              named.run != 0 ? fmt::format("no live run {} answers", named.run) : "no live run answers", place,
              found.others.empty() ? "see `tactbench runs list`; continue an ended run with `tactbench resume RUN`"
                                   : "live: " + listed(found.others));
}

void add_named_run(CLI::App& verb, NamedRun& named) {
  verb.add_option("run", named.run, "its number; may be omitted when one run is live");
}

void take_typed(NamedRun& named, const Session& session) {
  named.db_given = session.typed("--db");
  named.bench = session.typed_bench();
}

}  // namespace tactbench::bench
