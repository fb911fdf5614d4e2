// fleet push: brings ended runs to the fleet.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/common/private_files.h"
#include "bench/fleet/facts.h"
#include "db/fleet/body.h"
#include "db/fleet/schema.h"

namespace tactbench::bench {

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
                 one.content ? analysis::counted(frames, "frame") : std::string("what was said of it later"),
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
  CLI::App* verb = group.add_subcommand("push", "bring ended runs, and what was said of them since, to the fleet");
  add_fleet_option(*verb, "--to", options->to, session);
  verb->add_option("--patience", options->patience_s,
                   "seconds without a byte from the server until it counts as lost; more for one that is overloaded")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  verb->footer(
      "Each run is checked, sent in one transaction, read back, and kept when it is what was sent. A run that is not "
      "what was stored (tactbench verify) is not sent; the others are. The store is only read: a run that is being "
      "carried out does not notice.\n"
      "Exit codes: 0 all is there, 3 the server cannot be reached, refuses the login or was lost, 5 it cannot take a "
      "run.");
  verb->callback([options, &session] { push(*options, session); });
}

}  // namespace tactbench::bench
