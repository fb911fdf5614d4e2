// What init, recipes, config show and devices reset print and write, and what they refuse.
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

std::string file_lines(const std::string& folder, const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += folder + "/" + name + "\n";
  return text;
}

// Without comments.
std::string values_of_file(const std::string& path) { return sequences::TomlDocument::from_file(path).to_text(); }

const std::vector<std::string> kFilesOfInit = {"bench.toml", "sensor.toml", "limits.toml", "lab.toml"};

}  // namespace

TEST_CASE("init names each file that it wrote, and what to do next") {
  const TemporaryFolder folder;
  const auto init = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"init", folder.path(name)};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_init, words);
  };
  const std::string plain = folder.path("deep/plain");
  CHECK(init("deep/plain", {}).out == file_lines(plain, kFilesOfInit) +
                                          "\nNext:  tactbench sensors add MY-SENSOR --type " + plain +
                                          "/sensor.toml\n       tactbench run descending ascending --bench " + plain +
                                          "/bench.toml --sensor MY-SENSOR --operator NAME\n");
  CHECK(values_of_file(plain + "/bench.toml") == values_of_file(bench::find_config("simulated.toml")));
  CHECK(values_of_file(plain + "/limits.toml") == values_of_file(bench::find_config("limits.toml")));
  const std::string rig = folder.path("rig");
  CHECK(init("rig", {"--rig"}).out == file_lines(rig, kFilesOfInit) +
                                          "\nNext:  fill in bench.toml (serials, ports, certificates), then\n"
                                          "       tactbench devices check --bench " +
                                          rig + "/bench.toml\n");
  CHECK(values_of_file(rig + "/bench.toml") == values_of_file(bench::find_config("paper-rig.example.toml")));
  const std::string own = folder.path("own");
  std::vector<std::string> with_profile = kFilesOfInit;
  with_profile.emplace_back("tactbench.toml");
  CHECK(init("own", {"--operator", "A. \"Q\" Person"}).out ==
        file_lines(own, with_profile) + "\nNext:  cd " + own + ", then tactbench calibrate SERIAL\n");
  CHECK_THAT(read_file(own + "/tactbench.toml"), Catch::Contains("\noperator = \"A. \\\"Q\\\" Person\"\n"));
  const nlohmann::json told = nlohmann::json::parse(init("told", {"--json"}).out);
  CHECK(told.at("files").size() == 4);
  CHECK(told.at("files").at(3) == folder.path("told/lab.toml"));
  const Finished again = init("own", {});
  CHECK(again.code == 2);
  CHECK(again.err == "error: '" + own + "/bench.toml' exists already [TB-FILE-EXISTS]\n  at: " + own +
                         "/bench.toml\n  try: give another folder, or --replace to overwrite it\n");
  std::filesystem::remove(own + "/bench.toml");
  CHECK(init("own", {"--operator", "B"}).code == 2);
  for (const char* name : {"sensor.toml", "limits.toml", "lab.toml"}) std::filesystem::remove(own + "/" + name);
  CHECK_THAT(init("own", {"--operator", "B"}).err, Catch::Contains("tactbench.toml' exists already"));
  CHECK(init("own", {}).code == 0);  // no profile is to be written
  CHECK(init("own", {"--operator", "B", "--replace"}).code == 0);
  CHECK_THAT(read_file(own + "/tactbench.toml"), Catch::Contains("\noperator = \"B\"\n"));
  CHECK_THAT(init("other", {"--operator", " "}).err, Catch::Contains("the name is empty"));
  write_file(folder.path("file"), "x");
  const Finished blocked = init("file/sub", {});
  CHECK(blocked.code == 2);
  CHECK_THAT(blocked.err, Catch::Contains("[TB-FILE-WRITE]"));
}

TEST_CASE("init writes the shipped files, also over its own in the current folder") {
  const TemporaryFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  CHECK(verb_here(bench::add_init, {"init"}).code == 0);
  for (const std::string& name : kFilesOfInit) write_file(folder.path(name), "changed = true\n");
  const Finished again = verb_here(bench::add_init, {"init", "--replace"});
  CHECK(verb_here(bench::add_init, {"init", "beside"}).code == 0);
  std::filesystem::current_path(before);
  CHECK(again.code == 0);
  for (const char* name : {"sensor.toml", "limits.toml", "lab.toml"}) {
    CHECK(values_of_file(folder.path(name)) == values_of_file(bench::find_config(name)));
    CHECK(values_of_file(folder.path("beside/") + name) == values_of_file(bench::find_config(name)));
  }
}

TEST_CASE("recipes new: names of letters, digits, hyphens and underscores, and where the copy goes") {
  const TemporaryFolder folder;
  const auto make = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"recipes", "new"};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_recipes, words);
  };
  const std::string path = folder.path("out.toml");
  CHECK(make({"aZ09-_", "--from", "noise", "-o", path}).out ==
        path + ": 'aZ09-_', begun as a copy of 'noise'\n\nNext:  edit it, then\n       tactbench recipes check " +
            path + "\n");
  CHECK_THAT(read_file(path), Catch::Contains("\nname = \"aZ09-_\"\n"));
  for (const char* name : {"", "a b", "a.b", "a/b", "\xC3\xA4"}) {
    const Finished refused = make({name, "-o", folder.path("none.toml")});
    CHECK(refused.code == 2);
    CHECK(refused.err ==
          "error: '" + std::string(name) +
              "' is no name of a recipe [TB-USAGE]\n  at: recipes new\n  try: use letters, digits, - and "
              "_\n");
  }
  const Finished again = make({"b", "-o", path});
  CHECK(again.err == "error: '" + path + "' exists already [TB-FILE-EXISTS]\n  at: " + path +
                         "\n  try: give another name or -o FILE, or --replace to overwrite it\n");
  const nlohmann::json told = nlohmann::json::parse(make({"b", "-o", path, "--replace", "--json"}).out);
  CHECK(told.at("name") == "b");
  CHECK(told.at("from") == "production");
  CHECK(told.at("path") == path);
  std::string text = read_file(path);
  text.replace(text.find("name = \"b\""), 10, "name=\"b\"");
  write_file(folder.path("odd.toml"), text);
  CHECK(
      make({"c", "--from", folder.path("odd.toml"), "-o", folder.path("c.toml")}).err ==
      "error: the name of 'b' is not found in its file [TB-USAGE]\n  at: --from\n  try: start from a shipped recipe\n");
}

TEST_CASE("recipes check prints a good one's steps, frames and highest load, and goes on after a wrong one") {
  const TemporaryFolder folder;
  // 2 steps of conditioning, and a frame at 0, 5, 10, 5 and 0 psi, twice.
  write_file(folder.path("two.toml"),
             "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\n"
             "dwell_s = 3\n[conditioning]\ncycles = 1\npeak = 20\n");
  const Finished checked =
      verb_here(bench::add_recipes, {"recipes", "check", folder.path("none.toml"), folder.path("two.toml"), "ring"});
  CHECK(checked.code == 2);
  CHECK_THAT(checked.err, Catch::Contains("none.toml") && Catch::Contains("\n  try: "));
  CHECK_THAT(
      checked.out,
      Catch::StartsWith(folder.path("two.toml") +
                        ": recipe 'two' is good on bench 'simulated-rig': 12 steps, 10 frames, up to 20.0 psi\n") &&
          Catch::EndsWith(", up to 30.0 N\n"));
  CHECK_THAT(verb_here(bench::add_recipes, {"recipes", "check", folder.path("two.toml"), "--units", "bar"}).out,
             Catch::Contains("up to 1.38 bar"));
  const nlohmann::json told =
      nlohmann::json::parse(verb_here(bench::add_recipes, {"recipes", "check", folder.path("two.toml"), "--json"}).out);
  CHECK(told.at("bench") == "simulated-rig");
  const nlohmann::json& two = told.at("recipes").at(0);
  CHECK(two.at("steps") == 12);
  CHECK(two.at("frames") == 10);
  CHECK(two.at("highest") == "20.0 psi");
  CHECK(two.at("repeats") == 2);
  CHECK(two.at("good") == true);
  const Finished shown = verb_here(bench::add_recipes, {"recipes", "show", folder.path("two.toml")});
  CHECK(shown.out == "# " + folder.path("two.toml") + "\n" + read_file(folder.path("two.toml")));
  CHECK(nlohmann::json::parse(verb_here(bench::add_recipes, {"recipes", "show", folder.path("two.toml"), "--json"}).out)
            .at("text") == read_file(folder.path("two.toml")));
}

TEST_CASE("config show: a line each, and behind the values, in one column, where they come from") {
  const auto show = [](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"config", "show", "--bench", "simulated.toml"};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_config, words);
  };
  const Finished plain = show({"--set", "bench.location=\"here\""});
  CHECK(plain.code == 0);
  CHECK_THAT(plain.out, Catch::Contains("\nbench.location = \"here\"\n") && !Catch::Contains("  # "));
  const auto column_of = [](const std::string& text, const std::string& key) {
    const std::size_t at = ("\n" + text).find("\n" + key + " = ");
    return text.find("  # ", at) - at;
  };
  const std::string narrow = show({"--origin", "--set", "bench.location=\"here\""}).out;
  CHECK(column_of(narrow, "bench.id") == column_of(narrow, "bench.location"));
  CHECK_THAT(narrow, Catch::Contains("bench.location = \"here\"") && Catch::Contains("  # --set\n"));
  // At most 72 columns: what is longer has its origin two blanks behind it.
  const std::string wide = show({"--origin", "--set", "bench.location=\"" + std::string(90, 'x') + "\""}).out;
  CHECK(column_of(wide, "bench.id") == 72);
  CHECK_THAT(wide, Catch::Contains(std::string(90, 'x') + "\"  # --set"));
  const nlohmann::json told = nlohmann::json::parse(show({"--json", "--set", "bench.location=\"here\""}).out);
  CHECK(told.at("profile").empty());
  bool found = false;
  for (const nlohmann::json& setting : told.at("settings")) found = found || setting.at("value") == "\"here\"";
  CHECK(found);
}

TEST_CASE("devices reset shows the trip that it removes, and says when there is none") {
  const std::string id = "bench-to-reset";
  const auto reset = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "devices", "reset", "--bench", "simulated.toml", "--set", "bench.id=\"" + id + "\"", "--operator", "K. Lee"};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_devices, words);
  };
  CHECK(reset({}).out == "bench '" + id + "' is not tripped\n");
  const nlohmann::json none = nlohmann::json::parse(reset({"--json"}).out);
  CHECK(none.at("tripped") == false);
  CHECK_FALSE(none.contains("id"));
  const bench::TripFile file(id);
  REQUIRE(file.store({"TB-X", "it broke", 7, ""}));
  const std::string utc = file.read()->utc;
  CHECK(reset({}).out == "bench '" + id + "' tripped at " + utc + " (TB-X): it broke\nreset by K. Lee; logged in " +
                             file.log_path() + "\n");
  CHECK_FALSE(file.read());
  REQUIRE(file.store({"TB-X", "it broke", 7, ""}));
  const nlohmann::json told = nlohmann::json::parse(reset({"--json"}).out);
  CHECK(told.at("tripped") == true);
  CHECK(told.at("id") == "TB-X");
  CHECK(told.at("what") == "it broke");
  CHECK(told.at("run") == 7);
  CHECK_FALSE(file.read());
}
