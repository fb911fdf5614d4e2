// Signals, each at a moment of the run that is waited for.
#include <csignal>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "db/run_store.h"
#include "tests/bench/cli/small_bench.h"
#include "tests/support/paths.h"

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
        joined_arguments({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q"},
                         more),
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
