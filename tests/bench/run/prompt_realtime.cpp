// A run that asks the person at its terminal.
#include <catch2/catch.hpp>

#include "db/run_store.h"
#include "tests/support/in_terminal.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("prompt: the question of a recipe is asked at the terminal, and Enter answers it") {
  const TemporaryFolder folder;
  write_file(folder.path("asked.toml"),
             "schema = 1\nname = \"asked\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n[prompt]\nbefore = "
             "\"mount the sensor\"\n");
  REQUIRE(run_program(program_path(), {"init"}, folder.path()).code == 0);
  REQUIRE(run_program(program_path(), {"sensors", "add", "S-1", "--type", "sensor.toml"}, folder.path()).code == 0);
  InTerminal run(folder.path(),
                 {"run", "asked.toml", "--bench", "bench.toml", "--set", "bench.id=\"asked\"", "--sensor", "S-1",
                  "--operator", "A. Smith", "--no-seating"},
                 100, 40);
  REQUIRE(run.shows("tactbench resume 1"));
  run.type("\n");
  CHECK(run.wait() == 0);
  CHECK_THAT(run.shown(), Catch::Contains("mount the sensor"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  std::vector<std::string> states;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.kind == "state") states.push_back(event.detail.substr(0, event.detail.find(':')));
  }
  CHECK(states == std::vector<std::string>{"prepared -> running", "running -> pausing", "pausing -> paused",
                                           "paused -> running", "running -> stopping"});
}
