// What there is to choose from: recipes, stored models, signed reports.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::json;

TEST_CASE("recipes list and show know the shipped recipes, and leave out the suite beside them") {
  const TemporaryFolder folder;
  const json recipes = json::parse(call(folder, {"recipes", "list", "--json"}).out).at("recipes");
  const auto named = [&](const char* name) {
    return std::ranges::find_if(recipes, [&](const json& recipe) { return recipe.at("name") == name; });
  };
  REQUIRE(named("production") != recipes.end());
  CHECK(named("production")->at("frames") == 303);
  CHECK(named("production")->at("highest") == "60.0 psi");
  CHECK(named("nightly") == recipes.end());
  const Finished shown = call(folder, {"recipes", "show", "production"});
  CHECK(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains(read_file(source_path("sequences/production.toml"))));
  CHECK(call(folder, {"recipes", "show", "produktion"}).code == 2);
}

TEST_CASE("recipes new begins an own recipe with all comments, and writes over no file") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"recipes", "new", "mine", "--from", "noise"}).code == 0);
  const std::string text = read_file(folder.path("mine.toml"));
  const std::string shipped = read_file(source_path("sequences/noise.toml"));
  CHECK(text.size() + 1 == shipped.size());  // "mine" for "noise"
  CHECK(text.starts_with(shipped.substr(0, shipped.find("\nname"))));
  const std::string edited = text + "# edited\n";
  write_file(folder.path("mine.toml"), edited);
  for (const char* from : {"noise", "production"}) {
    check_refusal(call(folder, {"recipes", "new", "mine", "--from", from}), 2, "TB-FILE-EXISTS");
  }
  CHECK(read_file(folder.path("mine.toml")) == edited);
  CHECK(call(folder, {"recipes", "new", "my/own"}).code == 2);
  CHECK(call(folder, {"recipes", "new", "own", "--from", "nois"}).code == 2);
  CHECK(call(folder, {"recipes", "check", "mine.toml"}).code == 0);
}
