// fleet push: brings ended runs to the fleet, once or as long as the program runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "analysis/counted.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "db/fleet/migrations.h"
#include "db/fleet/push.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

struct PushOptions {
  std::string to;
  bool follow = false;
  double every_s = 5.0;
  int patience_s = static_cast<int>(fleet::kSilence.count());
};

// One connection, and what was sent by it.
class Pushing {
 public:
  Pushing(const PushOptions& options, Session& session)
      : session_(session),
        link_(options.to, std::chrono::seconds(options.patience_s)),
        store_(session.db),
        note_(session.db, link_.where()),
        folder_("tactbench-fleet"),
        push_(link_, store_, source_name(session.db), folder_.path()) {
    fleet::check_schema(link_);
  }

  // All that waits. A run that cannot be sent is left for the end: its error is thrown when the others are there.
  void all() {
    const std::vector<fleet::Waiting> waiting = push_.waiting();
    const auto noted = note_.fingerprints();
    note_known(waiting, noted);
    std::exception_ptr first;
    for (const fleet::Waiting& one : waiting) {
      try {
        const fleet::PushedRun pushed = push_.push(one);
        note_.keep(one.run, utc_now());
        tell(one, pushed);
      } catch (const fleet::FleetError& error) {
        if (error.id() != "TB-FLEET-DIFFERS" && error.id() != "TB-FLEET-TEXT") throw;
        if (!first) first = std::current_exception();
        ++left_;
      }
    }
    baselines_ += push_.push_baselines();
    note_.keep_try(utc_now(), {});
    if (first) std::rethrow_exception(first);
  }

  // Waits for a change of the store. False: the program shall end.
  bool wait_for_change(const StopRequest& stop, double every_s) {
    const std::int64_t version = store_.version();
    for (;;) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(every_s);
      while (std::chrono::steady_clock::now() < end) {
        if (stop.interrupts() > 0 || stop.ending() != 0) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
      if (store_.version() != version) return true;
      (void)link_.query("SELECT 1");  // a server that went is told now, not when the next run has ended
    }
  }

  void summary() const {
    const std::size_t ended = ended_;
    if (session_.json) {
      print_json("fleet.push", {{"fleet", link_.where()},
                                {"store", session_.db},
                                {"ended_runs", ended},
                                {"pushed", pushed_},
                                {"frames", frames_},
                                {"baselines", baselines_},
                                {"not_pushed", left_}});
      return;
    }
    if (session_.quiet) return;
    tty::print("{}: {}, {} sent now{}; {} ended in {}, {}\n", link_.where(), analysis::counted(pushed_.size(), "run"),
               analysis::counted(frames_, "frame"),
               baselines_ > 0 ? fmt::format(", {}", analysis::counted(baselines_, "baseline")) : "",
               analysis::counted(ended, "run has", "runs have"), session_.db,
               left_ == 0 ? "and all are there" : fmt::format("{} could not be sent", left_));
  }

 private:
  // A note that was lost, or is of another's push, is made good.
  void note_known(const std::vector<fleet::Waiting>& waiting, const std::map<std::string, std::string>& noted) {
    const std::vector<fleet::LocalRun> runs = store_.ended_runs();
    ended_ = runs.size();
    for (const fleet::LocalRun& run : runs) {
      const auto known = noted.find(run.uuid);
      if (known != noted.end() && known->second == run.fingerprint) continue;
      if (std::ranges::none_of(waiting, [&](const fleet::Waiting& one) { return one.run.run == run.run; }))
        note_.keep(run, utc_now());
    }
  }

  void tell(const fleet::Waiting& one, const fleet::PushedRun& pushed) {
    frames_ += pushed.frames;
    pushed_.push_back({{"run", one.run.run},
                       {"uuid", one.run.uuid},
                       {"fleet_run", pushed.number},
                       {"frames", pushed.frames},
                       {"fits", pushed.fits},
                       {"remarks", pushed.remarks}});
    if (session_.json || session_.quiet) return;
    tty::print("run {} is the fleet's run {}: {}{}\n", one.run.run, pushed.number,
               one.content ? analysis::counted(pushed.frames, "frame") : std::string("what was said of it later"),
               pushed.fits > 0 ? fmt::format(", {}", analysis::counted(pushed.fits, "fit")) : "");
    std::fflush(stdout);
  }

  Session& session_;
  fleet::Link link_;
  fleet::LocalRuns store_;
  fleet::PushedNote note_;
  ScratchFolder folder_;
  fleet::Push push_;
  nlohmann::ordered_json pushed_ = nlohmann::ordered_json::array();
  std::size_t ended_ = 0;
  std::int64_t frames_ = 0;
  int baselines_ = 0, left_ = 0;
};

void note_failure(const PushOptions& options, const Session& session, const Error& error) {
  try {
    fleet::PushedNote(session.db, fleet::where_of(options.to)).keep_try(utc_now(), error.what());
  } catch (const std::exception&) {  // the failure itself is told
  }
}

void push_once(const PushOptions& options, Session& session) {
  try {
    Pushing pushing(options, session);
    try {
      pushing.all();
    } catch (const fleet::FleetError& error) {
      if (error.id() == "TB-FLEET-DIFFERS" || error.id() == "TB-FLEET-TEXT") pushing.summary();
      throw;
    }
    pushing.summary();
  } catch (const fleet::FleetError&) {
    note_failure(options, session, as_error(std::current_exception()));
    throw;
  }
}

// Until Ctrl-C or a request to terminate. The server may go and come back.
void follow(const PushOptions& options, Session& session) {
  (void)db::RunStore::open_read_only(session.db);
  (void)fleet::where_of(options.to);
  const StopRequest stop;
  const auto ends = [&] { return stop.interrupts() > 0 || stop.ending() != 0; };
  std::string told;
  double pause_s = 1.0;
  constexpr double kLongestPause = 60.0;
  while (!ends()) {
    try {
      Pushing pushing(options, session);
      if (!told.empty() && !session.quiet) tty::print("the fleet is there again\n");
      told.clear();
      pause_s = 1.0;
      do pushing.all();
      while (pushing.wait_for_change(stop, options.every_s));
      return;
    } catch (const fleet::FleetError&) {
      const Error error = as_error(std::current_exception());
      if (error.code() == ExitCode::kUsage) throw;
      note_failure(options, session, error);
      if (told != error.id())
        tty::print(stderr, "warning: {} [{}]\n  try: {}\n  it is tried again until it works\n",
                   one_line(error.what(), kLongestText), error.id(), one_line(error.remedy(), kLongestText));
      told = error.id();
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(pause_s);
    while (!ends() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    pause_s = std::min(2.0 * pause_s, kLongestPause);
  }
}

void push(const PushOptions& options, Session& session) {
  if (!options.follow) return push_once(options, session);
  if (session.json)
    throw Error(ExitCode::kUsage, "TB-USAGE", "--json prints one document, and --follow does not end", "fleet push",
                "leave one of them out; tactbench fleet status --json shows how far a push has come");
  follow(options, session);
}

}  // namespace

void add_fleet_push(CLI::App& group, Session& session) {
  auto options = std::make_shared<PushOptions>();
  CLI::App* verb = group.add_subcommand(
      "push",
      "bring the store's ended runs, and what was said of them since, to the fleet; what is there is left alone");
  add_fleet_option(*verb, "--to", options->to, session);
  verb->add_flag(
      "--follow", options->follow,
      "go on with each run that ends, until Ctrl-C or a request to terminate; waits for a server that is away");
  verb->add_option("--every", options->every_s, "--follow: seconds between looks at the store")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  verb->add_option("--patience", options->patience_s,
                   "seconds without a byte from the server until it counts as lost; more for one that is overloaded")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  verb->footer(
      "Each run is sent in one transaction, read back, and kept when the content hash of what the server holds is that "
      "of "
      "the store. The store is only read: a run that is being carried out does not notice.\n"
      "Exit codes: 0 all is there, 3 the server cannot be reached, refuses the login or was lost, 5 it cannot take a "
      "run.");
  add_common(*verb, session);
  verb->callback([options, &session] { push(*options, session); });
}

}  // namespace tactbench::bench
