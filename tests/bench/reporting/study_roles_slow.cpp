// Roles of further runs, held against what the runs record.
#include "bench/reporting/study_roles.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"
#include "tests/support/run_recipe.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("a role that a run's own record contradicts is refused with that record") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(
      folder.path("loops.toml"),
      "schema = 1\nname = \"loops\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 4\ndwell_s = 1.0\n");
  const auto one = [&](const std::string& seed, std::vector<std::string> more) {
    more.insert(more.end(), {"--seed", seed});
    run_recipe(folder, "loops.toml", more);
  };
  one("1", {});
  one("2", {});  // the same mount, not turned
  one("3", {"--set", "simulation.turned_in_chamber_deg=90"});
  one("4", {"--set", "simulation.mount_seed=1"});
  one("5", {"--meta", "turned=180"});  // an operator's word, though the simulated one lies as before
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1"});  // 6
  run_recipe(folder, "rate-ramp");                            // 7
  REQUIRE(call(folder, {"fit", "1"}).code == 0);

  // The role that its record tells, or how it may be given, is told.
  for (const auto& [study, told] :
       {std::pair("2:mount", "--held-out 2"), std::pair("2:90", "2:0"), std::pair("3:180", "3:90"),
        std::pair("3:mount", "3:90"), std::pair("4:270", "4:0"), std::pair("5:90", "5:180"),
        std::pair("6:mount", "--studies 6\n"), std::pair("7:90", "--studies 7\n")}) {
    const Finished done = call(folder, {"report", "1", "--studies", study, "-o", "r.html"});
    INFO(study << ": " << done.err);
    CHECK(done.code == 2);
    CHECK_THAT(done.err, Catch::Contains("[TB-REPORT-STUDY]") && Catch::Contains(std::string("--studies ") + study) &&
                             Catch::Contains(told));
  }

  const Finished right =
      call(folder, {"report", "1", "--studies", "3:90", "4:mount", "6", "7", "--format", "json", "-o", "r.json"});
  INFO(right.err);
  REQUIRE((right.code == 0 || right.code == 6));
  const auto data = nlohmann::json::parse(read_file(folder.path("r.json")));
  CHECK(data["sections"]["studies"]["uniformity"]["angles_deg"] == nlohmann::json({0, 90}));
  CHECK(data["sections"]["studies"]["remount"]["degrees"] == 1);
}
