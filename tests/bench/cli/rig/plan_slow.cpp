// The verb plan as a person uses it: no device is there.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "bench/run/recipe_check.h"
#include "sequences/recipe.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using namespace tactbench;
using nlohmann::json;

TEST_CASE("plan: lists the same steps as the compiler") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& names :
       std::vector<std::vector<std::string>>{{"production", "ring"}, {"rate-ramp"}, {"random-reversal"}}) {
    std::vector<std::string> words = joined_arguments({"plan", "--steps"}, names);
    std::string lines;
    const auto steps = sequences::compile(bench::read_recipes(names));
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

TEST_CASE("plan: lists the shipped recipes, and rejects an unknown name") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"plan"}).code == 0);
  std::set<std::string> names, shipped;
  const json listed = json::parse(call(folder, {"plan", "--json"}).out);
  for (const json& recipe : listed["recipes"]) names.insert(recipe["name"].get<std::string>());
  for (const auto& entry : std::filesystem::directory_iterator(source_path("sequences")))
    if (entry.path().extension() == ".toml" && entry.path().stem() != "nightly") shipped.insert(entry.path().stem());
  CHECK(names == shipped);
  CHECK(call(folder, {"plan", "produktion"}).code == 2);
  CHECK(call(folder, {"run", "produktion", "--bench", "simulated.toml", "--sensor", "S", "--operator", "o"}).code == 2);
}

TEST_CASE("plan: rejects a step size that would exhaust memory") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"plan", "noise", "--set", "recipe.step=0.00001"}).code == 2);
}
