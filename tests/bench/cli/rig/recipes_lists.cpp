// The lists of shipped recipes that plan and recipes print, and what recipes check tells as JSON.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("plan without a recipe lists the shipped ones, and so does recipes list") {
  const Finished all = verb_here(bench::add_plan, {"plan"});
  CHECK(all.code == 0);
  CHECK_THAT(all.out, Catch::Contains("production        Production characterization (short)\n") &&
                          Catch::Contains("ring              Ring object under force (Tables 8 and 9)\n") &&
                          Catch::EndsWith("tactbench plan NAME... shows more; own recipes are given as files\n") &&
                          !Catch::Contains("nightly"));
  const nlohmann::json told = nlohmann::json::parse(verb_here(bench::add_plan, {"plan", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.plan.recipes");
  CHECK(told.at("recipes").size() == 15);
  const Finished list = verb_here(bench::add_recipes, {"recipes", "list"});
  CHECK_THAT(list.out,
             Catch::StartsWith("recipe              frames     highest  what it is\n") &&
                 Catch::Contains("\nring                    27      30.0 N  Ring object under force (Tables 8 "
                                 "and 9)\n") &&
                 Catch::EndsWith("\ntactbench recipes show NAME prints the file; recipes new MINE --from NAME "
                                 "makes one of your own\n"));
  CHECK_THAT(verb_here(bench::add_recipes, {"recipes", "list", "--units", "bar"}).out, Catch::Contains(" bar  "));
  const nlohmann::json listed = nlohmann::json::parse(verb_here(bench::add_recipes, {"recipes", "list", "--json"}).out);
  CHECK(listed.at("schema") == "tactbench.recipes.list");
  bool found = false;
  for (const nlohmann::json& one : listed.at("recipes")) {
    if (one.at("name") != "ring") continue;
    found = true;
    CHECK(one.at("title") == "Ring object under force (Tables 8 and 9)");
    CHECK(one.at("frames") == 27);
    CHECK(one.at("highest") == "30.0 N");
    CHECK(one.at("repeats") == 3);
    CHECK_THAT(one.at("file").get<std::string>(), Catch::EndsWith("/sequences/ring.toml"));
  }
  CHECK(found);
}

TEST_CASE("recipes check as JSON has a wrong recipe's error beside the good ones") {
  const TemporaryFolder folder;
  write_file(folder.path("one.toml"),
             "schema = 1\nname = \"one\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\n");
  const Finished done =
      verb_here(bench::add_recipes, {"recipes", "check", folder.path("one.toml"), folder.path("none.toml"), "--json"});
  CHECK(done.code == 2);
  CHECK(done.err.empty());
  const nlohmann::json recipes = nlohmann::json::parse(done.out).at("recipes");
  REQUIRE(recipes.size() == 2);
  CHECK(recipes.at(0).at("good") == true);
  CHECK(recipes.at(0).at("name") == "one");
  CHECK(recipes.at(1).at("good") == false);
  CHECK(recipes.at(1).at("file") == folder.path("none.toml"));
  CHECK(recipes.at(1).at("error").at("exit_code") == 2);
}
