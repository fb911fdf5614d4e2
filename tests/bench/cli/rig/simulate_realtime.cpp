// `tactbench simulate` in a process of its own, with the real drivers of another process on its wires.
#include <csignal>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/paths.h"
#include "tests/support/served_rig.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

const std::string kProgram = program_path();

}  // namespace

TEST_CASE("simulate: another process finds every instrument, watches them and carries out a run") {
  const ServedRig simulator(10.0);
  const Finished checked = simulator.run({"devices", "check", "--bench", "bench.toml", "--json"});
  INFO(checked.out << checked.err);
  CHECK(checked.code == 0);
  const json devices = json::parse(checked.out)["devices"];
  CHECK(devices.size() == 6);
  for (const json& device : devices) CHECK(device["state"] == "ok");
  const Finished watched =
      simulator.run({"devices", "watch", "--bench", "bench.toml", "--count", "2", "--interval", "0.1"});
  CHECK(watched.code == 0);
  CHECK_THAT(watched.out, Catch::Contains("feedback") && Catch::Contains("stage") && !Catch::Contains("TB-"));
  write_file(simulator.folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1\n");
  const Finished run = simulator.run(
      {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q", "--json"});
  INFO(run.err);
  CHECK(run.code == 0);
  const json row = json::parse(run.out);
  CHECK(row["frames"] == 5);
  CHECK(row["origin"] == "simulated");
  CHECK(row["safe_state"] == "verified");
}

TEST_CASE("simulate: a killed sequencer leaves a chamber that the module's own watchdog vents") {
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

TEST_CASE(
    "calibrate-reference: readings from the keyboard become a file that the bench takes, and the chamber is vented") {
  const TemporaryFolder folder;
  write_file(folder.path("readings"), "0.1\n20.3\nnonsense\n20.3\n0.1\n");
  const auto shell = [&](const std::string& words) {
    return run_program("/bin/sh", {"-c", kProgram + " " + words}, folder.path());
  };
  const Finished done = shell(
      "devices calibrate-reference --bench simulated.toml --gauge 'gauge 7' --uncertainty 0.05 --levels 0,20 -o "
      "fix.toml --json < readings");
  INFO(done.err);
  REQUIRE(done.code == 0);
  CHECK_THAT(done.err, Catch::Contains("vented, verified") && Catch::Contains("'nonsense' is not a pressure"));
  for (const char* asked :
       {" 1 of 4: 0 psi, increasing. Hand gauge reads [psi, q ends]: ", " 2 of 4: 20 psi, increasing. ",
        " 3 of 4: 20 psi, decreasing. ", " 4 of 4: 0 psi, decreasing. "})
    CHECK_THAT(done.err, Catch::Contains(asked));
  const json result = json::parse(done.out);
  CHECK(result["correction_psi"][1].get<double>() == Approx(0.3).margin(0.15));
  REQUIRE(run_program(kProgram, {"init"}, folder.path()).code == 0);
  const Finished shown = run_program(
      kProgram, {"devices", "check", "--bench", "bench.toml", "--set", "reference.correction_file=fix.toml"},
      folder.path());
  CHECK(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains("correction +0.1"));
  const Finished ended =
      shell("devices calibrate-reference --bench simulated.toml --gauge g --uncertainty 0 < /dev/null");
  CHECK(ended.code == 4);
  CHECK_THAT(ended.err, Catch::Contains("TB-CALIBRATION-STOPPED") && Catch::Contains("vented, verified"));
}

TEST_CASE("config show: every value with its origin") {
  const TemporaryFolder folder;
  const Finished shown =
      run_program(kProgram, {"config", "show", "--origin", "--set", "limits.trip_psi=64"}, folder.path());
  CHECK(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains("limits.trip_psi = 64") && Catch::Contains("# --set") &&
                            Catch::Contains("# default") && Catch::Contains("simulated.toml:"));
}
