// The verb plan as a person uses it: no device is there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "bench/config/config.h"
#include "bench/run/time_estimate.h"
#include "sequences/recipe.h"
#include "tests/bench/run/stored_past.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/processor_time.h"

using namespace tactbench::tests;
using namespace tactbench;
using nlohmann::json;

TEST_CASE("plan lists the very steps that the compiler makes") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& names :
       std::vector<std::vector<std::string>>{{"production", "ring"}, {"rate-ramp"}, {"random-reversal"}}) {
    std::vector<sequences::Recipe> recipes;
    std::vector<std::string> words = {"plan", "--steps"};
    for (const std::string& name : names) {
      recipes.push_back(sequences::read_recipe(bench::find_recipe(name)));
      words.push_back(name);
    }
    std::string lines;
    const auto steps = sequences::compile(recipes);
    for (const sequences::Step& step : steps) lines += step_line(step) + "\n";
    const Finished text = call(folder, words);
    CHECK(text.code == 0);
    CHECK(text.out.ends_with(lines));
    words.emplace_back("--json");
    const json list = json::parse(call(folder, words).out)["step_list"];
    REQUIRE(list.size() == steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) CHECK(list[i]["line"] == step_line(steps[i]));
  }
}

TEST_CASE("plan prints axes, margins, time with a band, bytes and devices") {
  const TemporaryFolder folder;
  const json plan = json::parse(call(folder, {"plan", "production", "register", "--json"}).out);
  CHECK(plan["margin_psi"] == 0.0);
  CHECK(plan["largest_force_n"] == 3.0);
  REQUIRE(plan["axes"].size() == 4);
  CHECK(plan["axes"][3]["axis"] == "force");
  CHECK(plan["axes"][3]["margin"] == 32.0);
  CHECK(plan["axes"][1]["axis"] == "x");
  CHECK(plan["axes"][1]["margin"] == 20.0);
  CHECK(plan["time"]["runs"] == 0);
  CHECK(plan["time"]["p10_s"] < plan["time"]["p50_s"]);
  CHECK(plan["time"]["p50_s"] < plan["time"]["p90_s"]);
  CHECK(plan["store_bytes"] > 200.0 * plan["frames"].get<double>());
  CHECK(plan["devices"] == json({"pressure source", "pressure reference", "tactile array", "stage", "force sensor"}));
  CHECK(!plan["fail_safe"].empty());
  const Finished text = call(folder, {"plan", "ring"});
  CHECK_THAT(text.out, Catch::Contains("by the model") && Catch::Contains("force up to") && Catch::Contains("30.0 N"));
  CHECK_THAT(text.out, Catch::Contains("plus 1 prompt"));
  CHECK(plan["time"]["prompts"] == 1);  // of register
}

TEST_CASE("plan lists parameters and takes them, and refuses with exit code 2") {
  const TemporaryFolder folder;
  const json listed =
      json::parse(call(folder, {"plan", "production", "--parameters", "--set", "recipe.repeats=5", "--json"}).out);
  bool found = false;
  for (const json& parameter : listed["parameters"]) {
    if (parameter["name"] != "repeats") continue;
    found = true;
    CHECK((parameter["value"] == 5.0 && parameter["default"] == 3.0 && parameter["low"] == 1.0));
  }
  CHECK(found);
  CHECK_THAT(call(folder, {"plan", "ring", "--parameters"}).out, Catch::Contains("x_mm") && Catch::Contains("0 to 60"));
  const Finished refused = call(folder, {"plan", "production", "--set", "recipe.repeats=99"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("'repeats' is 99, outside 1 to 20") &&
                              Catch::Contains("at: --set recipe.repeats=99 (over "));
  const Finished beyond = call(folder, {"plan", "ring", "--set", "stage.x.high_mm=20"});
  CHECK(beyond.code == 2);
  CHECK_THAT(beyond.err, Catch::Contains("TB-RECIPE-LIMIT"));
}

TEST_CASE("plan lists the levels of a limits file that a recipe does not measure") {
  const TemporaryFolder folder;
  for (const char* recipe : {"production", "descending", "ascending"}) {
    const Finished fits = call(folder, {"plan", recipe, "--limits", "limits.toml"});
    CHECK(fits.code == 0);
    CHECK_THAT(fits.out, Catch::Contains("every level to be judged is measured"));
  }
  const Finished lacks = call(folder, {"plan", "production", "--limits", "nightly-limits.toml"});
  CHECK(lacks.code == 6);
  CHECK_THAT(lacks.out, Catch::Contains("10 psi is not a level of this recipe, whose nearest are 8 psi and 12 psi"));
  const json told = json::parse(call(folder, {"plan", "production", "--limits", "nightly-limits.toml", "--json"}).out);
  CHECK(told["limits"]["levels_lacking"] == json::parse(R"([{"pressure_psi": 10.0, "nearest_psi": [8.0, 12.0]}])"));
  CHECK(call(folder, {"plan", "ring", "--limits", "limits.toml"}).code == 6);
}

TEST_CASE("plan lists what is shipped, and a misspelled name gets the nearest one") {
  const TemporaryFolder folder;
  const Finished list = call(folder, {"plan"});
  CHECK(list.code == 0);
  CHECK_THAT(list.out, Catch::Contains("production        Production characterization (short)\n") &&
                           Catch::Contains("ring") && !Catch::Contains("nightly"));
  CHECK(json::parse(call(folder, {"plan", "--json"}).out)["recipes"].size() == 15);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"plan", "produktion"},
           {"run", "produktion", "--bench", "simulated.toml", "--sensor", "S", "--operator", "o"}}) {
    const Finished near = call(folder, words);
    CHECK(near.code == 2);
    CHECK_THAT(near.err, Catch::Contains("no shipped recipe or suite of that name") &&
                             Catch::Contains("did you mean 'production'?") && Catch::Contains("random-reversal"));
  }
  CHECK_THAT(call(folder, {"plan", "production", "--bench", "simulatd.toml"}).err,
             Catch::Contains("did you mean 'simulated.toml'?"));
}

TEST_CASE("plan refuses at once a step that would use all memory") {
  const TemporaryFolder folder;
  const Finished refused = call(folder, {"plan", "noise", "--set", "recipe.step=0.00001"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("steps") && Catch::Contains("--set recipe.step") &&
                              Catch::Contains("a run may have 1000000 steps"));
}

TEST_CASE("an unknown option is named before a required one that is absent") {
  const TemporaryFolder folder;
  const Finished run = call(folder, {"run", "--bnech", "x"});
  CHECK(run.code == 2);
  CHECK_THAT(run.err, Catch::Contains("there is no option '--bnech' of 'tactbench run'") &&
                          Catch::Contains("did you mean '--bench'?"));
  CHECK_THAT(call(folder, {"runs", "show", "1", "--jsn"}).err,
             Catch::Contains("no option '--jsn' of 'tactbench runs show'") && Catch::Contains("'--json'"));
  CHECK_THAT(call(folder, {"run", "production"}).err, Catch::Contains("is required"));
}

TEST_CASE("a hundred recipes are estimated from their stored runs in 10 ms") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor({"S-1", "type", "", "", "", "", ""});
  std::vector<sequences::Recipe> recipes;
  for (int i = 0; i < 100; ++i) {
    recipes.push_back(recipe_named("recipe-" + std::to_string(i)));
    store_run(store, {recipes.back()}, {});
  }
  const auto steps = sequences::compile(recipes);
  double best_ms = 1e9;
  for (int attempt = 0; attempt < 10; ++attempt) {
    const double start_s = processor_seconds();
    bench::TimeEstimate estimate(recipes, steps, sequences::TimeModel());
    estimate.learn(store, "b", {}, false);
    const bench::TimeBand total = estimate.total();
    const double took_ms = 1e3 * (processor_seconds() - start_s);
    CHECK(total.runs == 1);
    CHECK(total.p50_s == Approx(100 * 60.0));
    best_ms = std::min(best_ms, took_ms);
  }
  INFO("100 recipes learned in " << best_ms << " ms");
  CHECK(best_ms < 10.0);
}
