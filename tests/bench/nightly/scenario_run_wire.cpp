// A scenario carried out in this process on the simulated rig: what its store, its result and its expectations hold.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/nightly/suite.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

class CarriedScenario {
 public:
  CarriedScenario() {
    write_file(folder_.path("short.toml"),
               "schema = 1\nname = \"short\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = "
               "20\ndwell_s = 0.5\nrepeats = 1\n[conditioning]\ncycles = 1\npeak = 60\n");
    scenario = parse_suite(
                   "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\nseed = "
                   "5\nsensor_seed = 17\n",
                   "s.toml")
                   .scenarios.at(0);
    scenario.label = "one-seed-5";
    scenario.recipes = {folder_.path("short.toml")};
  }
  ScenarioResult carry_out() { return bench::carry_out(scenario, path); }
  Scenario scenario;

 private:
  TemporaryFolder folder_;

 public:
  std::string path = folder_.path("one.db");
};

}  // namespace

TEST_CASE(
    "nightly scenario: without a fit its result has the values of the rig, and its store is marked as a scenario") {
  CarriedScenario made;
  made.scenario.fits = false;
  made.scenario.figures = {{"frames", {11.0, 11.0}}, {"none", {0.0, 1.0}}};
  const ScenarioResult result = made.carry_out();
  CHECK(result.name == "one-seed-5");
  CHECK(result.about == "first");
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("none"));
  REQUIRE(result.runs.size() == 1);
  CHECK(result.runs[0].run == 1);
  CHECK(result.runs[0].outcome == "completed");
  CHECK(result.runs[0].error.empty());
  CHECK(result.runs[0].safe == "verified");
  CHECK(result.figures.at("frames") == 11.0);
  CHECK(result.figures.at("branches_redone") == 0.0);
  CHECK(result.figures.at("flagged_frames") == 0.0);
  CHECK(result.verdicts.empty());
  CHECK(result.taxels.empty());
  CHECK(result.seconds > 0.0);
  CHECK(is_scenario_store(made.path));
  const db::RunStore store = db::RunStore::open_read_only(made.path);
  const db::RunRecord run = store.run(1);
  CHECK(result.figures.at("instruments") == static_cast<double>(run.devices.size()));
  CHECK(result.runs[0].content_sha256 == run.content_sha256);
  CHECK(run.sensor_serial == "SIM-0017");
  CHECK(run.operator_name == "nightly");
  CHECK(run.purpose == "nightly: one");
  CHECK((run.seed == 5 && run.sensor_seed == 17));
  CHECK(store.fits(1).empty());
}

TEST_CASE("nightly scenario: held-out runs have seeds of their own and are judged, the first one is void on request") {
  CarriedScenario made;
  made.scenario.held_out = {{"recipe.dwell_s=1"}, {}};
  made.scenario.void_held_out = true;
  made.scenario.verdicts = {{"unfit_taxels", "pass"}};
  const ScenarioResult result = made.carry_out();
  CHECK(result.wrong.empty());
  REQUIRE(result.runs.size() == 3);
  CHECK(result.figures.at("frames") == 33.0);
  CHECK(result.figures.contains("mean_error_psi"));
  CHECK(result.verdicts.contains("overall"));
  CHECK(result.verdicts.contains("mismatch 40 psi increasing"));
  CHECK(result.verdicts.at("unfit_taxels") == "pass");
  CHECK(result.taxels.empty());
  const db::RunStore store = db::RunStore::open_read_only(made.path);
  CHECK(store.run(2).seed == 1'000'005);
  CHECK(store.run(3).seed == 2'000'005);
  CHECK(store.run(2).overrides_json.find("dwell_s") != std::string::npos);
  CHECK(store.run(3).overrides_json.find("dwell_s") == std::string::npos);
  CHECK(store.run(2).void_by == "nightly");
  CHECK_FALSE(store.run(3).is_void());
  CHECK(store.verdicts(2).empty());
  CHECK(store.verdicts(3).size() == 8);
}

TEST_CASE("nightly scenario: only its own run is judged, an unexpected dead taxel is an error") {
  CarriedScenario made;
  made.scenario.own_run = true;
  made.scenario.set = {"simulation.defect=[{kind=\"dead\",row=3,column=4}]"};
  made.scenario.verdicts = {{"unfit_taxels", "fail"}};
  const ScenarioResult result = made.carry_out();
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("dead") && Catch::Contains("52"));
  CHECK(result.taxels.at("dead") == std::vector<int>{52});
  CHECK_FALSE(result.verdicts.contains("overall"));
  CHECK(result.verdicts.size() == 8);
  CHECK(db::RunStore::open_read_only(made.path).verdicts(1).empty());
}

TEST_CASE("nightly scenario: a failed analysis is reported, and after a failed run no analysis is tried") {
  CarriedScenario made;
  made.scenario.set = {"recipe.turning_points=[0, 20]"};
  const ScenarioResult result = made.carry_out();
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("TB-ANALYSIS-"));
  CarriedScenario failed;
  failed.scenario.held_out = {{}};
  failed.scenario.set = {"simulation.faults=[{kind=\"supply_lost\",at_s=20}]"};
  const ScenarioResult broken = failed.carry_out();
  CHECK(broken.runs.size() == 1);
  CHECK(broken.verdicts.empty());
  CHECK_FALSE(broken.figures.contains("instruments"));
  REQUIRE(broken.wrong.size() >= 2);
  CHECK_THAT(broken.wrong[0], Catch::Contains("failed") && Catch::Contains("completed"));
}
