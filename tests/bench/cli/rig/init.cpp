// Files and JSON of init, recipes, config and devices reset, and their refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "bench/cli/rig/init.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/guard/trip.h"
#include "bench/nightly/suite.h"
#include "bench/run/recipe_check.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Without comments.
std::string values_of_file(const std::string& path) { return sequences::TomlDocument::from_file(path).to_text(); }

}  // namespace

TEST_CASE("init: writes the files of each kind of bench, and overwrites none") {
  const TemporaryFolder folder;
  const auto init = [&](const std::string& name, const std::vector<std::string>& more) {
    return verb_here(bench::add_init, joined({"init", folder.path(name)}, more));
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
  const nlohmann::json printed = nlohmann::json::parse(init("told", {"--json"}).out);
  CHECK(printed.at("files").size() == 4);
  CHECK(printed.at("files").at(3) == folder.path("told/lab.toml"));
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

TEST_CASE("plan --copy: accepts letters, digits, hyphens and underscores in the name, and keeps all comments") {
  const TemporaryFolder folder;
  const auto copy = [&](const std::string& recipe, const std::string& file, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"plan", recipe, "--copy", folder.path(file)});
    return verb_here(bench::add_plan, more);
  };
  CHECK(copy("noise", "aZ09-_").code == 0);
  const std::string made = read_file(folder.path("aZ09-_.toml")), shipped = read_file(bench::find_recipe("noise"));
  CHECK(made.size() == shipped.size() + 1);  // the name alone
  CHECK(made.starts_with(shipped.substr(0, shipped.find("\nname"))));
  CHECK_THAT(made, Catch::Contains("\nname = \"aZ09-_\"\n"));
  for (const char* name : {"a b", "a.b", "\xC3\xA4", ".toml"})
    check_refusal(copy("noise", name), 2, "TB-USAGE", "plan --copy");
  CHECK_THAT(copy("noise", "aZ09-_.toml").err, Catch::Contains("[TB-FILE-EXISTS]"));
  CHECK(copy("nois", "c").code == 2);
  const nlohmann::json said = nlohmann::json::parse(copy("noise", "aZ09-_", {"--replace", "--json"}).out);
  CHECK((said.at("name") == "aZ09-_" && said.at("from") == "noise"));
  std::string text = made;
  text.replace(text.find("name = \"aZ"), 8, "name=\"");
  write_file(folder.path("odd.toml"), text);
  CHECK_THAT(copy(folder.path("odd.toml"), "c").err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("plan: reports steps and frames of a recipe, and prints its file") {
  const TemporaryFolder folder;
  // 2 steps of conditioning, and a frame at 0, 5, 10, 5 and 0 psi, twice.
  const std::string path = folder.path("two.toml");
  write_file(path,
             "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\n"
             "dwell_s = 3\n[conditioning]\ncycles = 1\npeak = 20\n");
  check_refusal(verb_here(bench::add_plan, {"plan", folder.path("none.toml")}), 2, "TB-FILE-MISSING");
  const nlohmann::json planned = nlohmann::json::parse(verb_here(bench::add_plan, {"plan", path, "--json"}).out);
  check_members(planned, R"({"steps": 12, "frames": 10, "highest_psi": 20.0, "bench": "simulated-rig"})");
  CHECK(verb_here(bench::add_plan, {"plan", path, "--print"}).out == "# " + path + "\n" + read_file(path));
  CHECK(nlohmann::json::parse(verb_here(bench::add_plan, {"plan", path, "--print", "--json"}).out).at("text") ==
        read_file(path));
}

TEST_CASE("plan: lists the shipped recipes without the nightly suite") {
  const nlohmann::json recipes =
      nlohmann::json::parse(verb_here(bench::add_plan, {"plan", "--json"}).out).at("recipes");
  const auto named = [&](const char* name) {
    return std::ranges::find_if(recipes, [&](const nlohmann::json& recipe) { return recipe.at("name") == name; });
  };
  REQUIRE(named("production") != recipes.end());
  CHECK(named("production")->at("frames") == 576);
  CHECK(named("production")->at("recipes").size() == 3);
  CHECK(named("production")->at("highest") == "60.0 psi");
  CHECK(named("nightly") == recipes.end());
  CHECK(verb_here(bench::add_plan, {"plan", "produktion", "--print"}).code == 2);
}

TEST_CASE("config: prints each value and where it comes from") {
  const auto show = [](const std::vector<std::string>& more) {
    return verb_here(bench::add_config, joined({"config", "--bench", "simulated.toml"}, more));
  };
  const Finished plain = show({"--set", "bench.location=\"here\""});
  CHECK(plain.code == 0);
  CHECK_THAT(plain.out, Catch::Contains("\nbench.location = \"here\"\n") && !Catch::Contains("  # "));
  CHECK_THAT(show({"--origin", "--set", "bench.location=\"here\""}).out, Catch::Contains("  # --set\n"));
  const nlohmann::json printed = nlohmann::json::parse(show({"--json", "--set", "bench.location=\"here\""}).out);
  CHECK(printed.at("profile").empty());
  bool found = false;
  for (const nlohmann::json& setting : printed.at("settings")) found = found || setting.at("value") == "\"here\"";
  CHECK(found);
}

TEST_CASE("devices reset: reports the trip that it removes, or that there is none") {
  const std::string id = "bench-to-reset";
  const auto reset = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_devices, joined({"devices", "reset", "--bench", "simulated.toml", "--set",
                                                 "bench.id=\"" + id + "\"", "--operator", "K. Lee"},
                                                more));
  };
  const nlohmann::json none = nlohmann::json::parse(reset({"--json"}).out);
  CHECK(none.at("tripped") == false);
  CHECK_FALSE(none.contains("id"));
  const bench::TripFile file(id);
  REQUIRE(file.store({"TB-X", "it broke", 7, ""}));
  const nlohmann::json printed = nlohmann::json::parse(reset({"--json"}).out);
  check_members(printed, R"({"tripped": true, "id": "TB-X", "what": "it broke", "run": 7})");
  CHECK_FALSE(file.read());
}

// The tables of keys: each row says all that a reader needs, each key that a shipped file holds or that reading it
// takes by default is a row, and the files of init hold a comment for each of their keys and the same values.

namespace {

std::string values_of(const std::string& toml) { return sequences::TomlDocument::from_text(toml, "t").to_text(); }

// "environment.sensor[0].serial" as "environment.sensor[].serial".
std::string without_numbers(std::string key) {
  std::erase_if(key, [](char c) { return c >= '0' && c <= '9'; });
  return key;
}

}  // namespace

TEST_CASE("key tables: each row has type, unit and meaning, and no key occurs twice") {
  for (const bench::FileKind& kind : bench::file_kinds()) {
    INFO(kind.title);
    std::set<std::string> keys;
    for (const sequences::KeyFacts& row : kind.keys()) {
      INFO(row.key);
      CHECK(keys.insert(row.key).second);
      CHECK((!row.type.empty() && !row.unit.empty() && row.meaning.size() > 8));
    }
    CHECK(keys.contains("schema"));
  }
}

TEST_CASE("key tables: every shipped file is read, and each value of a bench file has a row") {
  std::set<std::string> rows;
  for (const sequences::KeyFacts& row : bench::bench_keys()) rows.insert(without_numbers(row.key));
  for (const char* name : {"simulated.toml", "simulated-serial.toml", "paper-rig.example.toml"})
    for (const sequences::Setting& setting : bench::read_bench(bench::find_config(name), {}).settings) {
      INFO(setting.key);
      CHECK(rows.contains(without_numbers(setting.key)));
    }
  CHECK_NOTHROW(bench::read_sensor_type(bench::find_config("sensor.toml")));
  CHECK_NOTHROW(bench::read_laboratory(bench::find_config("lab.toml")));
  for (const char* name : {"limits.toml", "nightly-limits.toml"})
    CHECK_NOTHROW(bench::read_limits(bench::find_config(name)));
  for (const std::string& profile : bench::shipped_profiles()) CHECK_NOTHROW(bench::read_module_profile(profile));
  for (const std::string& name : bench::shipped_files("sequences")) {
    INFO(name);
    if (name == "nightly.toml")
      CHECK_NOTHROW(bench::read_suite(bench::find_recipe(name)));
    else
      CHECK_NOTHROW(bench::read_recipe_file(name));
  }
}

TEST_CASE("key tables: a file commented with key meanings has each meaning once and keeps its values") {
  const std::string toml =
      "schema = 1\n[settling]\npoll_s = 0.2\n# trace_s = 0\n[stage.x]\ndevice = 1\n[stage.y]\ndevice = 2\n[other]\nx = "
      "1\n";
  const std::vector<sequences::KeyFacts> keys = bench::bench_keys();
  const std::string text = bench::with_key_comments(toml, keys);
  CHECK(values_of(text) == values_of(toml));
  for (const char* key : {"schema", "settling.poll_s", "settling.trace_s", "stage.x.device", "stage.y.device"}) {
    INFO(key);
    const auto row = std::ranges::find(keys, key, &sequences::KeyFacts::key);
    REQUIRE(row != keys.end());
    CHECK(text.find("# " + row->meaning.substr(0, 40)) != std::string::npos);
  }
  for (const char* name : {"simulated.toml", "simulated-serial.toml", "paper-rig.example.toml"}) {
    const std::string shipped = read_file(bench::find_config(name));
    CHECK(values_of(bench::with_key_comments(shipped, keys)) == values_of(shipped));
  }
}
