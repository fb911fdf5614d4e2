// run: its document.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/check_refusal.h"

using namespace tactbench::tests;

TEST_CASE("run: its document") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  // A frame at 0, 10, 20, 10 and 0 psi after 1.1 s each: 0.5 s of ramp between two, and 0.65 s to settle.
  write_file(folder.path("steps.toml"),
             "schema = 1\nname = \"steps\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1.1\n");
  const Finished run = well(call(folder, {"run", "./steps.toml", "--bench", "simulated.toml", "--sensor", "S-1",
                                          "--operator", "t", "--no-seating", "--json"}));
  const nlohmann::json told = nlohmann::json::parse(run.out);
  CHECK(told.at("schema") == "tactbench.run");
  CHECK((told.at("run") == 1 && told.at("frames") == 5 && told.at("branches_redone") == 0));
  CHECK(told.at("process_seconds").get<double>() > 8.0);
  CHECK(told.at("waiting_seconds") == 0.0);
  CHECK(told.at("most_exchanges_a_step").get<int>() > 0);
  CHECK_FALSE(told.at("time_spent").get<std::string>().empty());
}
