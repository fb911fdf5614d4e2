// Output of plan for small recipes, with hand-computed figures: 20 psi/s, and 0.65 s to settle.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/bench/run/stored_past.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// One cycle to 20 psi, then a frame at 0, 5, 10, 5 and 0 psi, twice.
constexpr const char* kTwoLoops =
    "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\ndwell_s = 3\n"
    "[conditioning]\ncycles = 1\npeak = 20\n";
constexpr const char* kOneTouch =
    "schema = 1\nname = \"touch\"\nkind = \"press\"\ndwell_s = 1\n[press]\nobject = \"ring\"\nforces_n = [2, 4]\n"
    "positions_mm = [[20, 30]]\n[prompt]\nbefore = \"Ready?\"\n";
struct PlanFolder {
  PlanFolder() {
    write_file(folder.path("two.toml"), kTwoLoops);
    write_file(folder.path("touch.toml"), kOneTouch);
  }
  // Recipes are named by their files in this folder.
  [[nodiscard]] Finished plan(const std::vector<std::string>& recipes,
                              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"plan", "--db", folder.path("runs.db"), "--bench", "simulated.toml"};
    for (const std::string& recipe : recipes) words.push_back(folder.path(recipe + ".toml"));
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_plan, words);
  }
  [[nodiscard]] nlohmann::json json(const std::vector<std::string>& recipes, std::vector<std::string> more = {}) const {
    more.emplace_back("--json");
    return nlohmann::json::parse(plan(recipes, more).out);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("plan: the JSON document has every value, and each step on request") {
  const PlanFolder here;
  const nlohmann::json printed = here.json({"two"});
  CHECK(printed.at("schema") == "tactbench.plan");
  CHECK(printed.at("bench") == "simulated-rig");
  REQUIRE(printed.at("recipes").size() == 1);
  CHECK(printed.at("recipes").at(0).at("name") == "two");
  for (const nlohmann::json& time : {printed.at("recipes").at(0).at("time"), printed.at("time")}) {
    CHECK(time.at("p10_s").get<double>() == Approx(45.46));
    CHECK(time.at("p50_s").get<double>() == Approx(47.8));
    CHECK(time.at("p90_s").get<double>() == Approx(55.6));
    CHECK(time.at("runs") == 0);
    CHECK(time.at("prompts") == 0);
  }
  CHECK(printed.at("process_seconds").get<double>() == Approx(47.8));
  CHECK(printed.at("steps") == 12);
  CHECK(printed.at("frames") == 10);
  CHECK(printed.at("axes") ==
        nlohmann::json::parse(R"([{"axis": "pressure", "unit": "psi", "lowest": 0.0, "highest": 20.0, "limit": 60.0,
                                  "margin": 40.0}])"));
  check_members(printed, R"({"lowest_psi": 0.0, "highest_psi": 20.0, "largest_force_n": 0.0,
                          "command_limit_psi": 60.0, "margin_psi": 40.0, "store_bytes": 12440.0})");
  CHECK(printed.at("devices") == nlohmann::json({"pressure source", "pressure reference", "tactile array"}));
  CHECK(printed.at("instruments") == nlohmann::json::parse(R"json([{"role": "pressure reference",
      "model": "simulated transducer, 100 psi", "serial": "SIM-REF-1",
      "certificate": "SIM-CERT-1 (invented for the simulation)", "calibrated": "", "due": "", "overdue": false
}])json"));
  CHECK(printed.at("fail_safe").size() >= 4);
  CHECK_FALSE(printed.contains("limits"));
  CHECK_FALSE(printed.contains("step_list"));
  const nlohmann::json both = here.json({"two", "touch"}, {"--steps"});
  CHECK(both.at("recipes").at(1).at("time").at("prompts") == 1);
  CHECK(both.at("recipes").at(1).at("time").at("p50_s").get<double>() == Approx(57.8));
  CHECK(both.at("instruments").size() == 5);
  REQUIRE(both.at("step_list").size() == 22);
  const auto& measure = both.at("step_list").at(4);
  CHECK((measure.at("kind") == "measure" && measure.at("ordinal") == 2 && measure.at("frame") == true));
  CHECK((measure.at("setpoint_psi") == 10.0 && measure.at("dwell_s") == 3.0));
  const auto& press = both.at("step_list").at(18);
  CHECK((press.at("kind") == "press" && press.at("sequence") == 1 && press.at("ordinal") == 1));
  CHECK((press.at("force_n") == 4.0 && press.at("x_mm") == 20.0 && press.at("y_mm") == 30.0));
  CHECK(both.at("step_list").at(12).at("frame") == false);  // the prompt
}

TEST_CASE("plan: reports the levels of the limits that no recipe measures, with the nearest measured levels") {
  const PlanFolder here;
  const auto limits_at = [&](const std::string& psi) {
    write_file(here.folder.path("limits.toml"),
               "schema = 1\nname = \"mine\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 1\n"
               "distance_of_mean_percent_fs = 1\nunfit_taxels = 0\n[[mismatch]]\npressure_psi = " +
                   psi + "\nstd_percent_fs = 1\n");
  };
  const std::vector<std::string> given = {"--limits", here.folder.path("limits.toml")};
  limits_at("10");
  CHECK(here.plan({"two"}, given).code == 0);
  CHECK(here.json({"two"}, given).at("limits") == nlohmann::json::parse(R"({"name": "mine", "levels_lacking": []})"));
  limits_at("7");
  CHECK(here.plan({"two"}, given).code == 6);
  CHECK(here.json({"two"}, given).at("limits").at("levels_lacking") ==
        nlohmann::json::parse(R"([{"pressure_psi": 7.0, "nearest_psi": [5.0, 10.0]}])"));
}

TEST_CASE("plan: lists parameters with value, default and range") {
  const PlanFolder here;
  write_file(here.folder.path("free.toml"),
             "schema = 1\nname = \"free\"\nunit = \"psi\"\nturning_points = [0, \"$level\", 0]\nstep = 5\n"
             "[parameters.level]\ndefault = 10\nlow = 5\nhigh = 40\nunit = \"psi\"\nhelp = \"the top\"\n");
  const std::vector<std::string> asked = {"--parameters", "--set", "recipe.level=20"};
  CHECK(here.plan({"free", "two"}, {"--parameters"}).code == 0);
  const nlohmann::json printed = here.json({"free"}, asked);
  CHECK(printed.at("schema") == "tactbench.plan.parameters");
  CHECK(printed.at("parameters") == nlohmann::json::parse(R"([{"recipe": "free", "name": "level", "value": 20.0,
      "default": 10.0, "low": 5.0, "high": 40.0, "unit": "psi", "help": "the top"}])"));
}

TEST_CASE("plan: estimates times from completed runs of the same bench") {
  const PlanFolder here;
  const sequences::Recipe recipe = recipe_named("known");
  write_file(here.folder.path("known.toml"), recipe.text);
  Past past;
  {
    db::RunStore store = db::RunStore::open(here.folder.path("runs.db"), db::Durability::kNormal);
    store.add_sensor({"S-1", "type", "", "", "", "", ""});
    for (const char* bench : {"simulated-rig", "another", "simulated-rig"}) {
      past.bench = bench;
      store_run(store, {recipe}, past);  // 20 steps of 3 s
    }
  }
  const nlohmann::json time = here.json({"known"}).at("time");
  CHECK(time.at("runs") == 2);
  CHECK(time.at("p50_s").get<double>() == Approx(60.0).margin(1.0));
}
