// What plan prints of small recipes, every figure of it worked out by hand: 20 psi/s, and 0.65 s to settle.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/safety/fail_safe.h"
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
constexpr const char* kByTheModel = "by the model: no completed run of this recipe on this bench in the store";
constexpr const char* kHeadOfPlan = "recipe               steps  frames     highest      time           10 to 90 %\n";
constexpr const char* kReferenceOfPlan =
    "instruments that results are traced to:\n  - pressure reference, serial SIM-REF-1: certificate SIM-CERT-1 "
    "(invented for the simulation), no due date stated, U 0.05 psi (k = 2)\n";

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

std::string fail_safe_lines() {
  const bench::BenchConfig config = bench::read_bench(bench::find_config("simulated.toml"), {});
  std::string text = "fail-safe layers of bench 'simulated-rig':\n";
  for (const std::string& line : bench::fail_safe_layers(config)) text += "  - " + line + "\n";
  return text;
}

}  // namespace

TEST_CASE("plan prints one recipe's steps, frames, load, time, margins, bytes and instruments") {
  const PlanFolder here;
  const Finished done = here.plan({"two"});
  CHECK(done.code == 0);
  CHECK(done.err.empty());
  CHECK(done.out == kHeadOfPlan +
                        std::string("two                     12      10    20.0 psi   0:00:48    0:00:45 - "
                                    "0:00:56\n") +
                        "time in h:mm:ss of process time, " + kByTheModel +
                        "\npressure      0.00 to 20.00 psi, limit 60.00 psi, margin 40.00 psi\n"
                        "about 0.0 MB in the store\n"
                        "devices needed: pressure source, pressure reference, tactile array\n" +
                        kReferenceOfPlan + fail_safe_lines());
  const Finished metric = here.plan({"two"}, {"--units", "kPa"});
  CHECK_THAT(metric.out, Catch::Contains("   137.9 kPa   0:00:48") &&
                             Catch::Contains("\npressure      0.0 to 137.9 kPa, limit 413.7 kPa, margin 275.8 kPa\n") &&
                             Catch::Contains(", U 0.34 kPa (k = 2)\n") && !Catch::Contains(" psi"));
}

TEST_CASE("plan prints a line for each of several recipes and one for all, with prompts and forces") {
  const PlanFolder here;
  const Finished done = here.plan({"two", "touch"});
  CHECK(done.code == 0);
  const std::string stage =
      ": certificate SIM-CERT-3 (invented for the simulation), no due date stated, U 0.01 mm (k = "
      "2)\n";
  CHECK(done.out ==
        kHeadOfPlan +
            std::string("two                     12      10    20.0 psi   0:00:48    0:00:45 - 0:00:56\n"
                        "touch                   10       3       4.0 N   0:00:58    0:00:30 - 0:01:53\n"
                        "all                     22      13    20.0 psi   0:01:46    0:01:18 - 0:02:41\n"
                        "time in h:mm:ss of process time, ") +
            kByTheModel +
            "; plus 1 prompt and the operator's time to answer\n"
            "pressure      0.00 to 20.00 psi, limit 60.00 psi, margin 40.00 psi\n"
            "x            20.00 to 20.00 mm, limit 60.00 mm, margin 20.00 mm\n"
            "y            30.00 to 30.00 mm, limit 60.00 mm, margin 30.00 mm\n"
            "force         0.00 to 4.00 N, limit 35.00 N, margin 31.00 N\n"
            "force up to    4.00 N; the sensor's calibrated range is checked once it is open\n"
            "about 0.0 MB in the store\n"
            "devices needed: pressure source, pressure reference, tactile array, stage, force sensor\n" +
            kReferenceOfPlan + "  - stage x, serial SIM-STAGE-X" + stage + "  - stage y, serial SIM-STAGE-Y" + stage +
            "  - stage z, serial SIM-STAGE-Z" + stage +
            "  - force sensor, serial not stated: certificate SIM-CERT-2 (invented for the simulation), no due date "
            "stated, U 0.05 N (k = 2)\n" +
            fail_safe_lines());
  CHECK_THAT(here.plan({"touch", "touch"}).out,
             Catch::Contains("; plus 2 prompts and the operator's time to answer\n"));
  write_file(here.folder.path("soft.toml"),
             "schema = 1\nname = \"soft\"\nkind = \"press\"\n[press]\nobject = \"ring\"\nforces_n = [0.5, 0.75]\n"
             "positions_mm = [[20, 30]]\n");
  CHECK_THAT(here.plan({"soft"}).out, Catch::Contains("\nforce up to    0.75 N; "));
  // 8001 frames of 2 x 512 bytes and 220 for the row.
  write_file(here.folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 5, 0]\nstep = 5\n"
             "frames_per_level = 2667\nframe_interval_s = 0.1\n");
  CHECK_THAT(here.plan({"long"}).out, Catch::Contains("\nabout 10.0 MB in the store\n"));
}

TEST_CASE("plan as JSON has every figure, and each step where steps are asked for") {
  const PlanFolder here;
  const nlohmann::json told = here.json({"two"});
  CHECK(told.at("schema") == "tactbench.plan");
  CHECK(told.at("bench") == "simulated-rig");
  REQUIRE(told.at("recipes").size() == 1);
  CHECK(told.at("recipes").at(0).at("name") == "two");
  for (const nlohmann::json& time : {told.at("recipes").at(0).at("time"), told.at("time")}) {
    CHECK(time.at("p10_s").get<double>() == Approx(45.46));
    CHECK(time.at("p50_s").get<double>() == Approx(47.8));
    CHECK(time.at("p90_s").get<double>() == Approx(55.6));
    CHECK(time.at("runs") == 0);
    CHECK(time.at("prompts") == 0);
  }
  CHECK(told.at("process_seconds").get<double>() == Approx(47.8));
  CHECK(told.at("steps") == 12);
  CHECK(told.at("frames") == 10);
  CHECK(told.at("axes") ==
        nlohmann::json::parse(R"([{"axis": "pressure", "unit": "psi", "lowest": 0.0, "highest": 20.0, "limit": 60.0,
                                  "margin": 40.0}])"));
  CHECK(told.at("lowest_psi") == 0.0);
  CHECK(told.at("highest_psi") == 20.0);
  CHECK(told.at("largest_force_n") == 0.0);
  CHECK(told.at("command_limit_psi") == 60.0);
  CHECK(told.at("margin_psi") == 40.0);
  CHECK(told.at("store_bytes") == 12440.0);
  CHECK(told.at("devices") == nlohmann::json({"pressure source", "pressure reference", "tactile array"}));
  CHECK(told.at("instruments") == nlohmann::json::parse(R"json([{"role": "pressure reference",
      "model": "simulated transducer, 100 psi", "serial": "SIM-REF-1",
      "certificate": "SIM-CERT-1 (invented for the simulation)", "calibrated": "", "due": "", "overdue": false
}])json"));
  CHECK(told.at("fail_safe").size() >= 4);
  CHECK_FALSE(told.contains("limits"));
  CHECK_FALSE(told.contains("step_list"));
  const nlohmann::json both = here.json({"two", "touch"}, {"--steps"});
  CHECK(both.at("recipes").at(1).at("time").at("prompts") == 1);
  CHECK(both.at("recipes").at(1).at("time").at("p50_s").get<double>() == Approx(57.8));
  CHECK(both.at("instruments").size() == 5);
  REQUIRE(both.at("step_list").size() == 22);
  CHECK(both.at("step_list").at(4) == nlohmann::json::parse(R"({"kind": "measure", "sequence": 0, "repeat": 0,
      "branch": 0, "ordinal": 2, "setpoint_psi": 10.0, "force_n": 0.0, "x_mm": 0.0, "y_mm": 0.0, "dwell_s": 3.0,
      "ramp_psi_per_s": 0.0, "frame": true,
      "line": "measure sequence 0 repeat 0 branch 0 step 2: 10 psi (0 to 10 psi), dwell 3 s"})"));
  CHECK(both.at("step_list").at(18) == nlohmann::json::parse(R"({"kind": "press", "sequence": 1, "repeat": 0,
      "branch": 0, "ordinal": 1, "setpoint_psi": 0.0, "force_n": 4.0, "x_mm": 20.0, "y_mm": 30.0, "dwell_s": 1.0,
      "ramp_psi_per_s": 0.0, "frame": true,
      "line": "press sequence 1 repeat 0 branch 0 step 1: 4 N (0 to 4) at x 20 y 30 mm, dwell 1 s"})"));
  CHECK(both.at("step_list").at(12).at("frame") == false);  // the prompt
}

TEST_CASE("plan lists steps behind everything else, in the unit that is asked for") {
  const PlanFolder here;
  const std::string text = here.plan({"two"}, {"--steps"}).out;
  CHECK_THAT(text,
             Catch::StartsWith(here.plan({"two"}).out +
                               "conditioning sequence 0 repeat 0 branch -1 step 0: 20 psi (0 to 20 psi), dwell 3 "
                               "s\n") &&
                 Catch::EndsWith("measure sequence 0 repeat 1 branch 1 step 4: 0 psi (10 to 0 psi), dwell 3 s\n"));
  CHECK_THAT(here.plan({"two"}, {"--steps", "--units", "bar"}).out,
             Catch::EndsWith("step 4: 0 bar (0.6895 to 0 bar), dwell 3 s\n"));
}

TEST_CASE("plan learns times from completed runs, and says of how many") {
  const PlanFolder here;
  const sequences::Recipe recipe = recipe_named("known");
  write_file(here.folder.path("known.toml"), recipe.text);
  Past past;
  past.bench = "simulated-rig";
  const auto learned = [&] {
    const std::string text = here.plan({"known"}).out;
    const std::size_t row = text.find("\nknown"), end = text.find("\npressure");
    return text.substr(row + 1, end - row - 1);
  };
  {
    db::RunStore store = db::RunStore::open(here.folder.path("runs.db"), db::Durability::kNormal);
    store.add_sensor({"S-1", "type", "", "", "", "", ""});
    store_run(store, {recipe}, past);  // 20 steps of 3 s
  }
  CHECK(learned() ==
        "known                   20      18     8.0 psi   0:01:00    0:00:55 - 0:01:05\n"
        "time in h:mm:ss of process time, learned from 1 completed run");
  past.bench = "another";
  {
    db::RunStore store = db::RunStore::open(here.folder.path("runs.db"), db::Durability::kNormal);
    store_run(store, {recipe}, past);
    past.bench = "simulated-rig";
    store_run(store, {recipe}, past);
  }
  CHECK(learned() ==
        "known                   20      18     8.0 psi   0:01:00    0:01:00 - 0:01:00\n"
        "time in h:mm:ss of process time, learned from 2 completed runs");
}

TEST_CASE("plan names the levels of limits that no recipe measures, and their neighbours if there are any") {
  const PlanFolder here;
  const auto limits_at = [&](const std::string& psi) {
    write_file(here.folder.path("limits.toml"),
               "schema = 1\nname = \"mine\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 1\n"
               "distance_of_mean_percent_fs = 1\nunfit_taxels = 0\n[[mismatch]]\npressure_psi = " +
                   psi + "\nstd_percent_fs = 1\n");
  };
  const std::vector<std::string> given = {"--limits", here.folder.path("limits.toml")};
  limits_at("10");
  const Finished good = here.plan({"two"}, given);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Catch::EndsWith("\nlimits 'mine': every level to be judged is measured\n"));
  CHECK(here.json({"two"}, given).at("limits") == nlohmann::json::parse(R"({"name": "mine", "levels_lacking": []})"));
  limits_at("7");
  const Finished lacking = here.plan({"two"}, given);
  CHECK(lacking.code == 6);
  CHECK_THAT(lacking.out,
             Catch::EndsWith("\nlimits 'mine': 7 psi is not a level of this recipe, whose nearest are 5 psi "
                             "and 10 psi; non-uniformity there will be inconclusive\n"));
  CHECK_THAT(here.plan({"two", "touch"}, {"--limits", given[1], "--units", "kPa"}).out,
             Catch::EndsWith("\nlimits 'mine': 48.26 kPa is not a level of these recipes, whose nearest are 34.47 kPa "
                             "and 68.95 kPa; non-uniformity there will be inconclusive\n"));
  CHECK_THAT(here.plan({"touch"}, given).out,
             Catch::EndsWith("\nlimits 'mine': 7 psi is not a level of this recipe; non-uniformity there will be "
                             "inconclusive\n"));
  CHECK(here.json({"two"}, given).at("limits").at("levels_lacking") ==
        nlohmann::json::parse(R"([{"pressure_psi": 7.0, "nearest_psi": [5.0, 10.0]}])"));
}

TEST_CASE("plan warns of an instrument that is overdue, from the day after") {
  const PlanFolder here;
  const auto due = [&](const std::string& day) { return "reference.due=\"" + day + "\""; };
  const Finished late = here.plan({"two"}, {"--set", due("2020-01-31")});
  CHECK(late.code == 0);
  CHECK(
      late.err ==
      "warning: pressure reference (simulated transducer, 100 psi, serial SIM-REF-1) is OVERDUE for calibration since "
      "2020-01-31\n");
  CHECK_THAT(late.out, Catch::Contains("(invented for the simulation), OVERDUE since 2020-01-31, U 0.05 psi"));
  CHECK(here.json({"two"}, {"--set", due("2020-01-31")}).at("instruments").at(0).at("overdue") == true);
  const std::string tomorrow = bench::utc_days_ago(-1).substr(0, 10);
  const Finished in_time = here.plan({"two"}, {"--set", due(tomorrow)});
  CHECK(in_time.err.empty());
  CHECK_THAT(in_time.out, Catch::Contains("(invented for the simulation), due " + tomorrow + ", U 0.05 psi"));
  const nlohmann::json told = here.json({"two"}, {"--set", due(tomorrow)}).at("instruments").at(0);
  CHECK(told.at("overdue") == false);
  CHECK(told.at("due") == tomorrow);
}

TEST_CASE("plan lists parameters with their values, defaults and ranges") {
  const PlanFolder here;
  write_file(here.folder.path("free.toml"),
             "schema = 1\nname = \"free\"\nunit = \"psi\"\nturning_points = [0, \"$level\", 0]\nstep = 5\n"
             "[parameters.level]\ndefault = 10\nlow = 5\nhigh = 40\nunit = \"psi\"\nhelp = \"the top\"\n");
  const std::vector<std::string> asked = {"--parameters", "--set", "recipe.level=20"};
  const Finished listed = here.plan({"free", "two"}, {"--parameters"});
  CHECK(listed.code == 0);
  CHECK(listed.out ==
        "recipe            parameter          value   default  range               unit  help\n"
        "free              level                 10        10  5 to 40             psi   the top\n");
  CHECK_THAT(here.plan({"free"}, asked).out, Catch::EndsWith("level                 20        10  5 to 40             "
                                                             "psi   the top\n"));
  const nlohmann::json told = here.json({"free"}, asked);
  CHECK(told.at("schema") == "tactbench.plan.parameters");
  CHECK(told.at("parameters") == nlohmann::json::parse(R"([{"recipe": "free", "name": "level", "value": 20.0,
      "default": 10.0, "low": 5.0, "high": 40.0, "unit": "psi", "help": "the top"}])"));
}
