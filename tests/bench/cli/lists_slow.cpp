// What there is to choose from: recipes, stored models, signed reports.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

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
  CHECK_THAT(call(folder, {"recipes", "list"}).out, Catch::Contains("\nproduction             303    60.0 psi  Prod"));
  const Finished shown = call(folder, {"recipes", "show", "production"});
  CHECK(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains(read_file(source_path("sequences/production.toml"))));
  const Finished near = call(folder, {"recipes", "show", "produktion"});
  CHECK(near.code == 2);
  CHECK_THAT(near.err, Catch::Contains("did you mean 'production'?") && Catch::Contains("random-reversal"));
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
    const Finished again = call(folder, {"recipes", "new", "mine", "--from", from});
    CHECK(again.code == 2);
    CHECK_THAT(again.err, Catch::Contains("[TB-FILE-EXISTS]"));
  }
  CHECK(read_file(folder.path("mine.toml")) == edited);
  CHECK(call(folder, {"recipes", "new", "my/own"}).code == 2);
  CHECK(call(folder, {"recipes", "new", "own", "--from", "nois"}).code == 2);
  const Finished checked = call(folder, {"recipes", "check", "mine.toml"});
  CHECK(checked.code == 0);
  CHECK_THAT(checked.out, Catch::Contains("mine.toml: recipe 'mine' is good on bench '"));
}

TEST_CASE("recipes check reports each wrong file, and the good ones beside it") {
  const TemporaryFolder folder;
  write_file(folder.path("typo.toml"),
             "schema = 1\nname = \"typo\"\nunit = \"psi\"\nturning_point = [0, 60, 0]\nstep = 10\n");
  write_file(folder.path("high.toml"),
             "schema = 1\nname = \"high\"\nunit = \"psi\"\nturning_points = [0, 90, 0]\nstep = 10\n");
  const Finished checked = call(folder, {"recipes", "check", "typo.toml", "production", "high.toml"});
  CHECK(checked.code == 2);
  CHECK_THAT(checked.err, Catch::Contains("typo.toml") && Catch::Contains("'turning_points'") &&
                              Catch::Contains("[TB-RECIPE-LIMIT]") && Catch::Contains("high"));
  CHECK_THAT(checked.out, Catch::Contains("recipe 'production' is good") && !Catch::Contains("typo"));
  const Finished as_json = call(folder, {"recipes", "check", "typo.toml", "production", "--json"});
  CHECK(as_json.code == 2);
  const json list = json::parse(as_json.out).at("recipes");
  REQUIRE(list.size() == 2);
  CHECK(list.at(0).at("good") == false);
  CHECK(list.at(1).at("good") == true);
}

TEST_CASE("model list and reports list: nothing yet, then what fit and a signature have stored") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  write_file(folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 20\n"
             "repeats = 1\ndwell_s = 1.0\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  for (const char* seed : {"1", "2"})
    REQUIRE(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q",
                          "--seed", seed})
                .code == 0);
  CHECK_THAT(call(folder, {"model", "list"}).out, Catch::Contains("no models are stored"));
  CHECK_THAT(call(folder, {"reports", "list"}).out, Catch::Contains("no report is signed"));
  REQUIRE(call(folder, {"fit", "2"}).code == 0);
  REQUIRE(call(folder, {"fit", "1", "--model", "poly"}).code == 0);
  const json models = json::parse(call(folder, {"model", "list", "--json"}).out).at("models");
  REQUIRE(models.size() == 2);
  CHECK(models.at(0).at("model") == "1:2");
  CHECK(models.at(0).at("kind") == "poly");
  CHECK(models.at(1).at("model") == "2:1");
  CHECK(models.at(1).at("fitted_taxels") == 256);
  CHECK(call(folder, {"model", "show", "1:2"}).code == 0);
  const Finished one = call(folder, {"model", "list", "2"});
  CHECK_THAT(one.out, Catch::Contains("2:1       dynamic") && !Catch::Contains("poly"));
  CHECK(call(folder, {"model", "list", "7"}).code == 2);
  REQUIRE(call(folder, {"report", "2", "--approve-by", "C. Chief", "--without-verdict"}).code == 0);
  const json reports = json::parse(call(folder, {"reports", "list", "--json"}).out).at("reports");
  REQUIRE(reports.size() == 1);
  CHECK(reports.at(0).at("run") == 2);
  CHECK(reports.at(0).at("by") == "C. Chief");
  CHECK(reports.at(0).at("file") == "reports/run-" + reports.at(0).at("number").get<std::string>() + ".html");
  CHECK(json::parse(call(folder, {"reports", "list", "1", "--json"}).out).at("reports").empty());
}
