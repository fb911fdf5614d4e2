// Signals, each at a moment of the run that is waited for.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <csignal>
#include <filesystem>
#include <set>

#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"
#include "tests/support/run_recipe.h"
#include "tests/support/served_rig.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Of run 1, in the middle of which this is.
bool has_frames(const TemporaryFolder& folder) {
  try {
    return db::RunStore::open_read_only(folder.path("runs.db")).frame_count(1) > 0;
  } catch (const db::StoreError&) {  // it is being made
    return false;
  }
}

// 1000 repeats would take minutes: the run cannot end before a signal comes.
struct LongRunHere {
  LongRunHere() { begin_bench(folder, small_loop_text(2, 1000)); }
  Finished run(const Signal& signal, const std::vector<std::string>& more = {}) const {
    return run_program(
        program_path(),
        joined({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q"}, more),
        folder.path(), signal);
  }
  Finished signalled(int number) const {
    return run({number, [&] { return has_frames(folder); }});
  }
  [[nodiscard]] json shown() const { return json::parse(call(folder, {"runs", "show", "1", "--json"}).out); }
  TemporaryFolder folder;
};

}  // namespace

// Ctrl-C pauses first: control_realtime.cpp.
TEST_CASE("run: SIGTERM vents, closes the row in the store and keeps the frames") {
  const LongRunHere of;
  const Finished run = of.signalled(SIGTERM);
  check_refusal(run, 143, "TB-RUN-STOPPED");
  CHECK_THAT(run.err, Catch::Contains("vented, verified"));
  const json row = of.shown();
  CHECK((row["outcome"] == "stopped" && row["safe_state"] == "verified"));
  CHECK(row["frames"] > 0);
}

TEST_CASE("demo: Ctrl-C ends it during or after the runs and leaves no partial files") {
  const TemporaryFolder folder;
  const bool in_run = GENERATE(true, false);
  const auto has_come = [&] {
    if (in_run) return has_frames(folder);
    try {
      return db::RunStore::open_read_only(folder.path("runs.db")).run(6).outcome == db::Outcome::kCompleted;
    } catch (const db::StoreError&) {
      return false;
    }
  };
  std::vector<std::string> words = {"demo", "-q"};
  if (in_run) words.insert(words.end(), {"--specimen", "harsh", "--sensor-seed", "12"});
  const Finished demo = run_program(program_path(), words, folder.path(), {SIGINT, has_come});
  INFO(demo.err);
  CHECK(demo.code == 130);
  CHECK_THAT(demo.err, Catch::Contains(in_run ? "TB-RUN-STOPPED" : "TB-DEMO-STOPPED"));
  std::set<std::string> left;
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) left.insert(file.path().filename());
  CHECK(left == std::set<std::string>{"runs.db", "runs.db-lock"});
  CHECK(call(folder, {"verify"}).code == 0);
  const json first = json::parse(call(folder, {"runs", "show", "1", "--json"}).out);
  CHECK(first["sensor"] == (in_run ? "SIM-HARSH-0012" : "SIM-0001"));
  CHECK(first["specimen"] == (in_run ? "harsh" : "paper"));
}

TEST_CASE("run: the next start marks a run with a killed process as interrupted") {
  const LongRunHere of;
  CHECK(of.signalled(SIGKILL).code == -SIGKILL);
  const json dead = of.shown();
  CHECK(dead["outcome"] == "incomplete");
  CHECK(dead["frames"] > 0);
  well(of.run({}, {"--set", "recipe.repeats=1"}));
  CHECK(of.shown()["outcome"] == "interrupted");
  CHECK(of.shown()["frames"] == dead["frames"]);
}

// `tactbench simulate` in a separate process, with the real drivers of another process on its connections.

namespace {

const std::string kProgram = program_path();

}  // namespace

TEST_CASE("simulate: another process finds every instrument, reads them and completes a run") {
  const ServedRig simulator(10.0);
  const json devices =
      json::parse(well(simulator.run({"devices", "check", "--bench", "bench.toml", "--json"})).out)["devices"];
  CHECK(devices.size() == 6);
  for (const json& device : devices) CHECK(device["state"] == "ok");
  CHECK(simulator.run({"live", "--bench", "bench.toml", "--frames", "2", "--interval", "0.1"}).code == 0);
  write_file(simulator.folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1\n");
  const json row = json::parse(well(simulator.run({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1",
                                                   "--operator", "t", "-q", "--json"}))
                                   .out);
  check_members(row, R"({"frames": 5, "origin": "simulated", "safe_state": "verified"})");
}

TEST_CASE("simulate: after the sequencer is killed the watchdog of the module vents the chamber") {
  ServedRig simulator(1.0, {"dead_man.enabled=false"});
  write_file(simulator.folder.path("hold.toml"),
             "schema = 1\nname = \"hold\"\nunit = \"psi\"\nturning_points = [40, 60, 40]\nstep = 20\ndwell_s = 600\n");
  const auto run = simulator.start_run("hold.toml");
  constexpr double kPatience = 60.0;
  REQUIRE(simulator.seconds_until([](double psi) { return psi > 39.0; }, kPatience) < kPatience);
  run->signal(SIGKILL);
  CHECK(run->wait() == -SIGKILL);
  CHECK(simulator.psi() > 20.0);  // nobody else vents
  CHECK(simulator.seconds_until_safe(kPatience) < kPatience);
}
