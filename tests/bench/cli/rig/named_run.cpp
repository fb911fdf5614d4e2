// Which live run a person means, and what is said when none or several could be meant.
#include "bench/cli/rig/named_run.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/run/control/machine_name.h"
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

// The whole error of what `choose` refuses; "taken" where it refuses nothing.
template <class Choose>
std::string whole_refusal(const Choose& choose) {
  const auto error = tests::refusal_by(choose);
  if (!error) return "taken";
  CHECK(error->code() == ExitCode::kUsage);
  return error->id() + " | " + error->what() + " | " + error->where() + " | " + error->remedy();
}

std::string place_of_runs() { return "runs listed in /proc/net/unix as " + shown_name(""); }

}  // namespace

TEST_CASE("named run: a live run and a silent bench in words") {
  CHECK(listed({live_run(7, "b-1")}) == "run 7 of /s/b-1.db on bench 'b-1' (paused, step 3/40)");
  LiveRun denied = live_run(7, "b-1");
  denied.denied = true;
  CHECK(listed({denied}) == "a run on bench 'b-1' (user 3999999 (pid 812))");
  CHECK(silent_text(silent_bench(9, false, true)) == "run 9 on bench 'b-2' does not answer (user 3999999 (pid 77))");
  CHECK(silent_text(silent_bench(0, false, false)) == "what holds the lock on bench 'b-2' does not answer");
  CHECK(silent_text(silent_bench(9, false, false)) == "run 9 on bench 'b-2' does not answer");
  const bool root = ::geteuid() == 0;  // root is heard by all, so that a stranger's silence is silence
  CHECK(silent_text(silent_bench(9, true, true)) ==
        (root ? "run 9 on bench 'b-2' does not answer (user 3999999 (pid 77))"
              : "bench 'b-2' is held by another user (user 3999999 (pid "
                "77))"));
  CHECK(listed({live_run(7, "b-1"), live_run(8, "b-3")}, {silent_bench(9, false, false)}) ==
        "run 7 of /s/b-1.db on bench 'b-1' (paused, step 3/40); run 8 of /s/b-3.db on bench 'b-3' (paused, step 3/40); "
        "run 9 on bench 'b-2' does not answer");
  CHECK(listed({}).empty());
}

TEST_CASE("named run: the one run that answers is meant, and beside silent benches only when it is named") {
  const NamedRun unnamed;
  NamedRun by_bench, by_store, by_number;
  by_bench.bench = "b-1";
  by_store.db_given = true;
  by_number.run = 7;
  Candidates found;
  found.runs = {live_run(7, "b-1")};
  for (const NamedRun& named : {unnamed, by_bench, by_store, by_number})
    for (const bool urgent : {false, true}) CHECK(only_one(found, named, "stop", urgent).status.run == 7);
  found.silent = {silent_bench(9, true, false)};  // a stranger's could not be commanded anyway
  CHECK(only_one(found, unnamed, "stop", false).status.run == 7);
  found.silent.push_back(silent_bench(9, false, false));
  for (const NamedRun& named : {by_bench, by_store}) CHECK(only_one(found, named, "stop", false).status.run == 7);
  CHECK(only_one(found, unnamed, "panic", true).status.run == 7);
  found.silent = {silent_bench(9, false, false)};
  const std::string ambiguous = "TB-RUN-AMBIGUOUS | 2 runs are live | " + place_of_runs() +
                                " | name one: tactbench stop --bench ID, or RUN --db STORE; live: run 7 of /s/b-1.db "
                                "on bench 'b-1' (paused, step "
                                "3/40); run 9 on bench 'b-2' does not answer";
  for (const NamedRun& named : {unnamed, by_number})
    CHECK(whole_refusal([&] { (void)only_one(found, named, "stop", false); }) == ambiguous);
  found.silent.clear();
  found.runs.push_back(live_run(8, "b-3"));
  for (const bool urgent : {false, true})
    CHECK_THAT(whole_refusal([&] { (void)only_one(found, by_bench, "pause", urgent); }),
               Catch::StartsWith("TB-RUN-AMBIGUOUS | 2 runs are live | ") &&
                   Catch::Contains("name one: tactbench pause --bench ID"));
}

TEST_CASE("named run: what does not answer is told before that nothing is live") {
  const NamedRun unnamed;
  NamedRun by_number;
  by_number.run = 12;
  Candidates found;
  CHECK(whole_refusal([&] { (void)only_one(found, unnamed, "stop", false); }) ==
        "TB-RUN-NOT-LIVE | no live run answers | " + place_of_runs() +
            " | see `tactbench runs list`; continue an ended run with `tactbench resume RUN`");
  found.others = {live_run(7, "b-1")};
  CHECK(whole_refusal([&] { (void)only_one(found, by_number, "stop", false); }) ==
        "TB-RUN-NOT-LIVE | no live run 12 answers | " + place_of_runs() +
            " | live: run 7 of /s/b-1.db on bench 'b-1' (paused, step 3/40)");
  found.silent = {silent_bench(9, false, true), silent_bench(0, false, false)};
  const std::string kill =
      " | check the rig: the process is stopped, or opens its devices. `kill -CONT 77` continues a stopped process, "
      "`kill -KILL 77` ends it, and its dead-man vents";
  CHECK(whole_refusal([&] { (void)only_one(found, by_number, "stop", true); }) ==
        "TB-RUN-SILENT | run 9 on bench 'b-2' does not answer (user 3999999 (pid 77)); what holds the lock on bench "
        "'b-2' does not answer | " +
            shown_name("b-2") + kill);
  CHECK_THAT(whole_refusal([&] { refuse_silent({silent_bench(0, false, false)}); }), Catch::Contains("kill -KILL PID"));
  const std::string stranger = whole_refusal([&] { refuse_silent({silent_bench(9, true, true)}); });
  if (::geteuid() == 0) {
    CHECK_THAT(stranger, Catch::StartsWith("TB-RUN-SILENT | run 9 on bench") && Catch::EndsWith(kill));
  } else {
    CHECK(stranger ==
          "TB-RUN-DENIED | bench 'b-2' is held by another user (user 3999999 (pid 77)): neither root, nor your own "
          "user, nor of the group 'tactbench' | " +
              shown_name("b-2") +
              " | ask that user, or give the command as root; members of the group 'tactbench' may command each "
              "other's runs");
  }
}

TEST_CASE("named run: two paths of one store are one, and a bench is named by its file or its id") {
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
