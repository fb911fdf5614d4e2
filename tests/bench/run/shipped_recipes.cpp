#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "bench/run/recipe_check.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::bench;
using sequences::Recipe;
using sequences::Step;

namespace {

std::vector<std::string> shipped() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    const std::string stem = entry.path().stem();
    if (entry.path().extension() == ".toml" && stem != "nightly")  // the suite, read in a test of its own
      names.push_back(stem);
  }
  return names;
}

BenchConfig simulated(const std::vector<sequences::Override>& overrides = {}) {
  return read_bench(find_config("simulated.toml"), overrides);
}

}  // namespace

TEST_CASE("shipped recipes: all compile and are within the limits of both shipped benches") {
  const std::vector<std::string> names = shipped();
  const BenchConfig rig = read_bench(find_config("paper-rig.example.toml"), {});
  for (const std::string& name : names) {
    INFO(name);
    const sequences::RecipeFile file = read_recipe_file(name);
    REQUIRE(!file.recipes.empty());
    if (file.recipes.size() > 1) {  // of shipped parts, which are checked here as it sets them
      check_recipes(file.recipes, simulated());
      check_recipes(file.recipes, rig);
      continue;
    }
    const Recipe& recipe = file.recipes.front();
    CHECK(recipe.name == name);
    CHECK(recipe.text.starts_with("# "));
    check_recipes({recipe}, simulated());
    check_recipes({recipe}, rig);
    const std::vector<Step> steps = sequences::compile(recipe, 0);
    CHECK(!steps.empty());
    CHECK(!devices_needed({recipe}).empty());
    for (const Margin& margin : margins(steps, rig)) CHECK(margin.within());
    std::set<std::pair<int, int>> places;  // of frames: one each
    for (const Step& step : steps) CHECK((!has_frame(step) || places.emplace(step.repeat, step.ordinal).second));
  }
}

TEST_CASE("shipped recipes: every parameter can be set to both ends of its range") {
  for (const std::string& name : shipped()) {
    const sequences::RecipeFile file = read_recipe_file(name);
    if (file.recipes.size() > 1) continue;
    for (const sequences::Parameter& p : file.recipes.front().parameters) {
      INFO(name << " " << p.name);
      CHECK((p.low <= p.standard && p.standard <= p.high));
      CHECK(!p.help.empty());
      for (const double end : {p.low, p.high}) {
        const Recipe set = sequences::read_recipe(find_recipe(name), {{p.name, std::to_string(end)}});
        check_recipes({set}, simulated());
      }
    }
  }
}
