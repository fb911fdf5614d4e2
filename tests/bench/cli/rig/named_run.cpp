// Which live run a person means, and what is refused when none or several could be meant.
#include "bench/cli/rig/control.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/run/control/locks.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

constexpr uid_t kNobodysNumber = 3999999;  // no user of this machine

LiveRun live_run(std::int64_t number, const std::string& bench) {
  LiveRun live;
  live.name = live.bench = bench;
  live.server = {812, kNobodysNumber, false};
  live.status.run = number;
  live.status.state = RunState::kPaused;
  live.status.store = "/s/" + bench + ".db";
  live.status.step = 3;
  live.status.steps = 40;
  return live;
}

SilentBench silent_bench(std::int64_t run, bool stranger, bool with_process) {
  SilentBench silent;
  silent.name = silent.bench = "b-2";
  silent.run = run;
  silent.stranger = stranger;
  if (with_process) silent.server = Peer{77, kNobodysNumber, false};
  return silent;
}

// The identifier of what `choose` refuses; "taken" where it refuses nothing.
template <class Choose>
std::string named_run_refusal(const Choose& choose) {
  const auto error = tests::refusal_by(choose);
  if (!error) return "taken";
  CHECK(error->code() == ExitCode::kUsage);
  return error->id();
}

}  // namespace

TEST_CASE("named run: a command goes to the only live run, or if a bench is silent only to a run that is named") {
  const LiveRunSelector unnamed;
  LiveRunSelector by_bench, by_store, by_number;
  by_bench.bench = "b-1";
  by_store.db_given = true;
  by_number.run = 7;
  Candidates found;
  found.runs = {live_run(7, "b-1")};
  for (const LiveRunSelector& named : {unnamed, by_bench, by_store, by_number})
    for (const bool urgent : {false, true}) CHECK(require_single_run(found, named, "stop", urgent).status.run == 7);
  found.silent = {silent_bench(9, true, false)};  // a stranger's could not be commanded anyway
  CHECK(require_single_run(found, unnamed, "stop", false).status.run == 7);
  found.silent.push_back(silent_bench(9, false, false));
  for (const LiveRunSelector& named : {by_bench, by_store})
    CHECK(require_single_run(found, named, "stop", false).status.run == 7);
  CHECK(require_single_run(found, unnamed, "panic", true).status.run == 7);
  found.silent = {silent_bench(9, false, false)};
  for (const LiveRunSelector& named : {unnamed, by_number})
    CHECK(named_run_refusal([&] { (void)require_single_run(found, named, "stop", false); }) == "TB-RUN-AMBIGUOUS");
  found.silent.clear();
  found.runs.push_back(live_run(8, "b-3"));
  for (const bool urgent : {false, true})
    CHECK(named_run_refusal([&] { (void)require_single_run(found, by_bench, "pause", urgent); }) == "TB-RUN-AMBIGUOUS");
}

TEST_CASE("named run: a silent bench is reported before the absence of a live run") {
  const LiveRunSelector unnamed;
  LiveRunSelector by_number;
  by_number.run = 12;
  Candidates found;
  CHECK(named_run_refusal([&] { (void)require_single_run(found, unnamed, "stop", false); }) == "TB-RUN-NOT-LIVE");
  found.others = {live_run(7, "b-1")};
  CHECK(named_run_refusal([&] { (void)require_single_run(found, by_number, "stop", false); }) == "TB-RUN-NOT-LIVE");
  found.silent = {silent_bench(9, false, true), silent_bench(0, false, false)};
  CHECK(named_run_refusal([&] { (void)require_single_run(found, by_number, "stop", true); }) == "TB-RUN-SILENT");
  const std::string stranger = named_run_refusal([&] { refuse_silent({silent_bench(9, true, true)}); });
  if (::geteuid() == 0) {
    CHECK(stranger == "TB-RUN-SILENT");
  } else {
    CHECK(stranger == "TB-RUN-DENIED");
  }
}

TEST_CASE("named run: two paths of one store are equal, a bench is named by its file or its id") {
  const tests::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("in"));
  tests::write_file(folder.path("runs.db"), "x");
  std::filesystem::create_symlink("runs.db", folder.path("link.db"));
  CHECK(same_store(folder.path("runs.db"), folder.path("in/../runs.db")));
  CHECK(same_store(folder.path("runs.db"), folder.path("link.db")));
  CHECK_FALSE(same_store(folder.path("runs.db"), folder.path("other.db")));
  CHECK(bench_id_of("simulated.toml") == "simulated-rig");
  CHECK(bench_id_of("b-1").size() == 3);
  CHECK(bench_id_of("").empty());
}
