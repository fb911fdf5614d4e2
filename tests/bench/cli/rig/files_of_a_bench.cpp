// What init, recipes, config show and devices reset write and tell, and what they refuse.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/guard/trip.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Without comments.
std::string values_of_file(const std::string& path) { return sequences::TomlDocument::from_file(path).to_text(); }

}  // namespace

TEST_CASE("init writes the files of each kind of bench, and none over another") {
  const TemporaryFolder folder;
  const auto init = [&](const std::string& name, const std::vector<std::string>& more) {
    return verb_here(bench::add_init, joined_words({"init", folder.path(name)}, more));
  };
  const std::string plain = folder.path("deep/plain");
  CHECK(init("deep/plain", {}).code == 0);
  CHECK(values_of_file(plain + "/bench.toml") == values_of_file(bench::find_config("simulated.toml")));
  for (const std::string name : {"/sensor.toml", "/limits.toml", "/lab.toml"})
    CHECK(values_of_file(plain + name) == values_of_file(bench::find_config(name.substr(1))));
  const std::string rig = folder.path("rig");
  CHECK(init("rig", {"--rig"}).code == 0);
  CHECK(values_of_file(rig + "/bench.toml") == values_of_file(bench::find_config("paper-rig.example.toml")));
  const std::string own = folder.path("own");
  CHECK(init("own", {"--operator", "A. \"Q\" Person"}).code == 0);
  CHECK_THAT(read_file(own + "/tactbench.toml"), Catch::Contains("\noperator = \"A. \\\"Q\\\" Person\"\n"));
  const nlohmann::json told = nlohmann::json::parse(init("told", {"--json"}).out);
  CHECK(told.at("files").size() == 4);
  CHECK(told.at("files").at(3) == folder.path("told/lab.toml"));
  check_refusal(init("own", {}), 2, "TB-FILE-EXISTS");
  std::filesystem::remove(own + "/bench.toml");
  CHECK(init("own", {"--operator", "B"}).code == 2);
  for (const char* name : {"sensor.toml", "limits.toml", "lab.toml"}) std::filesystem::remove(own + "/" + name);
  CHECK(init("own", {"--operator", "B"}).code == 2);  // the profile is there
  CHECK(init("own", {}).code == 0);                   // no profile is to be written
  CHECK(init("own", {"--operator", "B", "--replace"}).code == 0);
  CHECK_THAT(read_file(own + "/tactbench.toml"), Catch::Contains("\noperator = \"B\"\n"));
  CHECK(init("other", {"--operator", " "}).code == 2);
  write_file(folder.path("file"), "x");
  check_refusal(init("file/sub", {}), 2, "TB-FILE-WRITE");
}

TEST_CASE("recipes new: names of letters, digits, hyphens and underscores, and where the copy goes") {
  const TemporaryFolder folder;
  const auto make = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_recipes, joined_words({"recipes", "new"}, more));
  };
  const std::string path = folder.path("out.toml");
  CHECK(make({"aZ09-_", "--from", "noise", "-o", path}).code == 0);
  const std::string copy = read_file(path), shipped = read_file(bench::find_recipe("noise"));
  CHECK(copy.size() == shipped.size() + 1);  // the name alone, and with all comments
  CHECK(copy.starts_with(shipped.substr(0, shipped.find("\nname"))));
  CHECK_THAT(copy, Catch::Contains("\nname = \"aZ09-_\"\n"));
  for (const char* name : {"", "a b", "a.b", "a/b", "\xC3\xA4"}) {
    check_refusal(make({name, "-o", folder.path("none.toml")}), 2, "TB-USAGE", "recipes new");
  }
  const Finished again = make({"b", "-o", path});
  CHECK_THAT(again.err, Catch::Contains("[TB-FILE-EXISTS]"));
  CHECK(make({"c", "--from", "nois", "-o", folder.path("c.toml")}).code == 2);
  const nlohmann::json told = nlohmann::json::parse(make({"b", "-o", path, "--replace", "--json"}).out);
  CHECK(told.at("name") == "b");
  CHECK(told.at("from") == "production");
  CHECK(told.at("path") == path);
  std::string text = read_file(path);
  text.replace(text.find("name = \"b\""), 10, "name=\"b\"");
  write_file(folder.path("odd.toml"), text);
  CHECK_THAT(make({"c", "--from", folder.path("odd.toml"), "-o", folder.path("c.toml")}).err,
             Catch::Contains("[TB-USAGE]") && Catch::Contains("\n  at: --from\n"));
}

TEST_CASE("recipes check tells a good one's steps, frames and highest load, and goes on after a wrong one") {
  const TemporaryFolder folder;
  // 2 steps of conditioning, and a frame at 0, 5, 10, 5 and 0 psi, twice.
  write_file(folder.path("two.toml"),
             "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\n"
             "dwell_s = 3\n[conditioning]\ncycles = 1\npeak = 20\n");
  const Finished checked =
      verb_here(bench::add_recipes, {"recipes", "check", folder.path("none.toml"), folder.path("two.toml"), "ring"});
  CHECK(checked.code == 2);
  CHECK_THAT(checked.err, Catch::Contains("none.toml") && Catch::Contains("\n  try: "));
  const Finished as_json =
      verb_here(bench::add_recipes, {"recipes", "check", folder.path("two.toml"), folder.path("none.toml"), "--json"});
  CHECK(as_json.code == 2);
  CHECK(as_json.err.empty());
  const nlohmann::json told = nlohmann::json::parse(as_json.out);
  CHECK(told.at("bench") == "simulated-rig");
  REQUIRE(told.at("recipes").size() == 2);
  CHECK(told.at("recipes").at(1).at("good") == false);
  CHECK(told.at("recipes").at(1).at("file") == folder.path("none.toml"));
  CHECK(told.at("recipes").at(1).at("error").at("exit_code") == 2);
  const nlohmann::json& two = told.at("recipes").at(0);
  check_members(two, R"({"steps": 12, "frames": 10, "highest": "20.0 psi", "repeats": 2, "good": true})");
  const Finished shown = verb_here(bench::add_recipes, {"recipes", "show", folder.path("two.toml")});
  CHECK(shown.out == "# " + folder.path("two.toml") + "\n" + read_file(folder.path("two.toml")));
  CHECK(nlohmann::json::parse(verb_here(bench::add_recipes, {"recipes", "show", folder.path("two.toml"), "--json"}).out)
            .at("text") == read_file(folder.path("two.toml")));
}

TEST_CASE("recipes list knows the shipped recipes, and leaves out the suite beside them") {
  const nlohmann::json recipes =
      nlohmann::json::parse(verb_here(bench::add_recipes, {"recipes", "list", "--json"}).out).at("recipes");
  const auto named = [&](const char* name) {
    return std::ranges::find_if(recipes, [&](const nlohmann::json& recipe) { return recipe.at("name") == name; });
  };
  REQUIRE(named("production") != recipes.end());
  CHECK(named("production")->at("frames") == 576);
  CHECK(named("production")->at("recipes").size() == 3);
  CHECK(named("production")->at("highest") == "60.0 psi");
  CHECK(named("nightly") == recipes.end());
  CHECK(verb_here(bench::add_recipes, {"recipes", "show", "produktion"}).code == 2);
}

TEST_CASE("config show: each value, and where it comes from") {
  const auto show = [](const std::vector<std::string>& more) {
    return verb_here(bench::add_config, joined_words({"config", "show", "--bench", "simulated.toml"}, more));
  };
  const Finished plain = show({"--set", "bench.location=\"here\""});
  CHECK(plain.code == 0);
  CHECK_THAT(plain.out, Catch::Contains("\nbench.location = \"here\"\n") && !Catch::Contains("  # "));
  CHECK_THAT(show({"--origin", "--set", "bench.location=\"here\""}).out, Catch::Contains("  # --set\n"));
  const nlohmann::json told = nlohmann::json::parse(show({"--json", "--set", "bench.location=\"here\""}).out);
  CHECK(told.at("profile").empty());
  bool found = false;
  for (const nlohmann::json& setting : told.at("settings")) found = found || setting.at("value") == "\"here\"";
  CHECK(found);
}

TEST_CASE("devices reset tells the trip that it removes, and that there is none") {
  const std::string id = "bench-to-reset";
  const auto reset = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_devices, joined_words({"devices", "reset", "--bench", "simulated.toml", "--set",
                                                       "bench.id=\"" + id + "\"", "--operator", "K. Lee"},
                                                      more));
  };
  const nlohmann::json none = nlohmann::json::parse(reset({"--json"}).out);
  CHECK(none.at("tripped") == false);
  CHECK_FALSE(none.contains("id"));
  const bench::TripFile file(id);
  REQUIRE(file.store({"TB-X", "it broke", 7, ""}));
  const nlohmann::json told = nlohmann::json::parse(reset({"--json"}).out);
  check_members(told, R"({"tripped": true, "id": "TB-X", "what": "it broke", "run": 7})");
  CHECK_FALSE(file.read());
}
