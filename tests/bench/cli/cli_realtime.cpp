// Signals, each at a moment of the run that is waited for.
#include <csignal>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Of run 1, in the middle of which this is.
bool has_frames(const std::string& db_path) {
  try {
    return db::RunStore::open_read_only(db_path).frame_count(1) > 0;
  } catch (const db::StoreError&) {  // it is being made
    return false;
  }
}

}  // namespace

// Ctrl-C pauses first: control_realtime.cpp.
TEST_CASE("a request to terminate vents, closes the row and keeps the frames") {
  const TemporaryFolder folder;
  // 1000 repeats would take minutes: the run cannot end before the signal comes.
  const std::string recipe =
      "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n";
  write_file(folder.path("long.toml"), recipe);
  const std::string program = program_path();
  REQUIRE(run_program(program, {"init"}, folder.path()).code == 0);
  REQUIRE(run_program(program, {"sensors", "add", "S-1", "--type", "sensor.toml"}, folder.path()).code == 0);
  const Finished run =
      run_program(program, {"run", "long.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q"},
                  folder.path(), {SIGTERM, [&] { return has_frames(folder.path("runs.db")); }});
  INFO(run.err);
  CHECK(run.code == 143);
  CHECK_THAT(run.err, Catch::Contains("[TB-RUN-STOPPED]") && Catch::Contains("vented, verified"));
  const json row = json::parse(run_program(program, {"runs", "show", "1", "--json"}, folder.path()).out);
  CHECK(row["outcome"] == "stopped");
  CHECK(row["safe_state"] == "verified");
  CHECK(row["frames"] > 0);
  CHECK(row["frames"] < 61000);
}

TEST_CASE("demo: Ctrl-C ends it during or after the runs and leaves no partial files") {
  const TemporaryFolder folder;
  const bool in_run = GENERATE(true, false);
  const auto has_come = [&] {
    if (in_run) return has_frames(folder.path("runs.db"));
    try {
      return db::RunStore::open_read_only(folder.path("runs.db")).run(5).outcome == db::Outcome::kCompleted;
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
  CHECK(run_program(program_path(), {"db", "check"}, folder.path()).code == 0);
  const json first = json::parse(run_program(program_path(), {"runs", "show", "1", "--json"}, folder.path()).out);
  CHECK(first["sensor"] == (in_run ? "SIM-HARSH-0012" : "SIM-0001"));
  CHECK(first["specimen"] == (in_run ? "harsh" : "paper"));
}

TEST_CASE("a run whose process was killed is found and marked interrupted by the next start") {
  const TemporaryFolder folder;
  write_file(folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
  const std::string program = program_path();
  REQUIRE(run_program(program, {"init"}, folder.path()).code == 0);
  REQUIRE(run_program(program, {"sensors", "add", "S-1", "--type", "sensor.toml"}, folder.path()).code == 0);
  const std::vector<std::string> words = {"run", "long.toml",  "--bench", "bench.toml", "--sensor",
                                          "S-1", "--operator", "t",       "-q"};
  const Signal kill{SIGKILL, [&] { return has_frames(folder.path("runs.db")); }};
  CHECK(run_program(program, words, folder.path(), kill).code == -SIGKILL);
  const auto show = [&] {
    return json::parse(run_program(program, {"runs", "show", "1", "--json"}, folder.path()).out);
  };
  const json dead = show();
  CHECK(dead["outcome"] == "incomplete");
  CHECK(dead["frames"] > 0);
  std::vector<std::string> next = words;
  next.insert(next.end(), {"--set", "recipe.repeats=1"});
  REQUIRE(run_program(program, next, folder.path()).code == 0);
  CHECK(show()["outcome"] == "interrupted");
  CHECK(show()["frames"] == dead["frames"]);
}
