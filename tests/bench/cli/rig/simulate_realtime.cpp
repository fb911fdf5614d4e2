// `tactbench simulate` in a separate process, with the real drivers of another process on its connections.
#include <csignal>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"
#include "tests/support/served_rig.h"

using namespace tactbench::tests;
using nlohmann::json;

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
