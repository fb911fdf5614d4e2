#include "bench/run/control/locks.h"

#include <fmt/format.h>

#include <thread>

#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/run/control/control_client.h"

namespace tactbench::bench {

namespace {

constexpr devices::Nanoseconds kDeadManEnds = std::chrono::seconds(15);

// Who holds it, and with which run; a stopped process does not answer.
std::string holder_of(const MachineName& name) {
  const std::optional<LiveRun> live = send_command(name.text(), Command::kStatus);
  if (!live || live->denied) return name.owner();
  return fmt::format("{}, run {} of {}", peer_text(live->server), live->status.run, live->status.store);
}

[[noreturn]] void refuse_bench(const std::string& what, const MachineName& name, const std::string& remedy) {
  throw Error("TB-BENCH-LOCKED", what, shown_name(name.text()), remedy);
}

}  // namespace

MachineName dead_man_name(const std::string& bench_id, devices::Nanoseconds longest) {
  constexpr auto kTurn = std::chrono::milliseconds(10);
  const auto end = std::chrono::steady_clock::now() + longest;
  for (;;) {
    MachineName name(file_name(bench_id) + "/dead-man");
    if (name.held() || std::chrono::steady_clock::now() >= end) return name;
    std::this_thread::sleep_for(kTurn);
  }
}

BenchLock::BenchLock(const BenchConfig& config)
    : name_(config.in_process ? MachineName() : MachineName(file_name(config.id))) {
  if (config.in_process) return;
  if (!name_.held())
    refuse_bench(fmt::format("bench '{}' is in use by {}", config.id, holder_of(name_)), name_,
                 "wait for it to end, or end it: tactbench stop --bench " + config.id);
  const MachineName dead_man = dead_man_name(config.id, kDeadManEnds);
  if (dead_man.held()) return;
  refuse_bench(
      fmt::format("the dead-man ({}) of the run before is still making bench '{}' safe", dead_man.owner(), config.id),
      dead_man, "inspect the rig: the chamber may hold pressure; then try again");
}

}  // namespace tactbench::bench
