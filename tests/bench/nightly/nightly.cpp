#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "bench/nightly/night.h"
#include "sequences/toml/strict_toml.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

const char* const kNightHead = "schema = 1\nname = \"s\"\n";
const char* const kOne = "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\n";

std::string with(const char* head, const char* rest) { return fmt::format("{}{}", head, rest); }

std::string refusal(const std::string& text) {
  try {
    (void)parse_suite(text, "s.toml");
  } catch (const sequences::FileError& error) {
    return fmt::format("{}: {}", error.where(), error.what());
  }
  return "accepted";
}

ScenarioResult came_out(const std::string& outcome = "completed", const std::string& error = "") {
  ScenarioResult result;
  result.name = "one";
  result.runs = {{1, outcome, error, "verified", "ab"}};
  result.figures = {{"frames", 211.0}};
  result.verdicts = {{"unfit_taxels", "fail"}, {"mismatch 40 psi up", "pass"}, {"mismatch 40 psi down", "fail"}};
  result.taxels = {{"dead", {3, 4}}};
  result.seconds = 1.5;
  return result;
}

}  // namespace

TEST_CASE("the shipped suite has at least thirty scenarios, all readable, and every shipped recipe") {
  const Suite suite = read_suite(tactbench::tests::source_path("sequences/nightly.toml"));
  CHECK(suite.scenarios.size() >= 30);
  for (const auto& file : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    const std::string recipe = file.path().stem().string();
    if (file.path().extension() != ".toml" || recipe == "nightly") continue;
    INFO(recipe);
    CHECK(std::ranges::any_of(suite.scenarios, [&](const Scenario& scenario) {
      return std::ranges::find(scenario.recipes, recipe) != scenario.recipes.end();
    }));
  }
}

TEST_CASE("a faulty suite file: the error names the place") {
  CHECK(refusal(kNightHead).find("no scenario") != std::string::npos);
  CHECK(refusal(with(kOne, "recipe = \"x\"\n")).find("s.toml:6") != std::string::npos);
  CHECK(refusal(with(kOne, "recipes = \"ring\"\n")).find("must be a list of texts") != std::string::npos);
  CHECK(refusal(with(kOne, "recipes = [\"ring\", 3]\n")).find("element 2 of 'recipes'") != std::string::npos);
  CHECK(refusal(with(kOne, "[scenario.taxels]\nbroken = [1]\n")).find("'broken' is not a taxel's status") !=
        std::string::npos);
  CHECK(refusal(with(kOne, "[scenario.taxels]\ndead = [1.5]\n")).find("1.5") != std::string::npos);
  CHECK(refusal(with(kOne, "[scenario.figures]\nframes = [2, 1]\n")) != "accepted");
  CHECK(refusal(with(kOne, "own_run = true\n[scenario.verdicts]\nmismatch = \"good\"\n")) != "accepted");
  CHECK(refusal(with(kOne, "own_run = true\n[scenario.verdicts]\nmismatch = \"pass\"\n")) == "accepted");
  CHECK(refusal(with(kOne, "held_out = []\n[scenario.verdicts]\noverall = \"fail\"\n")) == "accepted");
  CHECK(refusal(with(kOne, "[scenario.verdicts]\nmismatch = \"pass\"\n"))
            .find("no run to be judged except the fit's own") != std::string::npos);
  CHECK(refusal(with(kOne, "own_run = true\nheld_out = []\n")) != "accepted");
  CHECK(refusal(with(kOne, "void_held_out = true\n")).find("no held-out run") != std::string::npos);
  CHECK(refusal(with(kOne, "fits = false\n[scenario.taxels]\ndead = [1]\n")).find("come from a fit") !=
        std::string::npos);
  CHECK(refusal(with(kOne, "[[scenario]]\nname = \"one\"\nabout = \"again\"\n")).find("two scenarios") !=
        std::string::npos);
  CHECK(refusal(with(kNightHead, "[[scenario]]\nname = \"../x\"\nabout = \"\"\n")).find("names a file") !=
        std::string::npos);
}

TEST_CASE("each difference from the expected result is named on its own line") {
  Scenario scenario =
      parse_suite(with(kOne,
                       "own_run = true\n[scenario.taxels]\ndead = [4, 3]\n[scenario.verdicts]\nunfit_taxels = "
                       "\"fail\"\n[scenario.figures]\nframes = [211, 212]\n"),
                  "s.toml")
          .scenarios.front();
  CHECK(differences(scenario, came_out()).empty());
  CHECK(differences(scenario, came_out("failed", "TB-X")) ==
        std::vector<std::string>{"the outcome is failed, must be completed", "the error is TB-X, must be none"});
  scenario.taxels = {{"stuck", {9}}};
  scenario.verdicts = {{"mismatch", "pass"}, {"worst_taxel_error", "pass"}};
  scenario.figures = {{"frames", {1.0, 2.0}}, {"mean_error_psi", {0.0, 1.0}}};
  CHECK(differences(scenario, came_out()) ==
        std::vector<std::string>{"the list of dead taxels is 3, 4, must be none",
                                 "the list of stuck taxels is none, must be 9",
                                 "the verdict on mismatch 40 psi down is fail, must be pass",
                                 "there is no verdict by worst_taxel_error, must be pass",
                                 "frames is 211, must lie in 1 to 2", "there is no figure mean_error_psi"});
  ScenarioResult nan = came_out();
  nan.figures["frames"] = std::nan("");
  CHECK(differences(scenario, nan).at(4).find("frames is nan") == 0);
}

TEST_CASE("a scenario's result is written to text and read back unchanged") {
  ScenarioResult result = came_out();
  result.wrong = {"a \"line\"\n<b>"};
  CHECK(to_json(result_from_json(to_json(result))) == to_json(result));
  CHECK_THROWS_AS(result_from_json("{"), std::invalid_argument);
  CHECK_THROWS_AS(result_from_json("{\"name\": 3}"), std::invalid_argument);
}

TEST_CASE("JUnit XML is well-formed for any scenario text, and names scenarios that did not run") {
  Suite suite = parse_suite(with(kOne,
                                 "[[scenario]]\nname = \"two\"\nabout = \"<&>\"\n[[scenario]]\nname = "
                                 "\"three\"\nabout = \"never reached\"\n"),
                            "s.toml");
  ScenarioResult red = came_out();
  red.name = "two";
  red.about = "<&>";
  red.wrong = {"said \"<b>\" & \x01", "more"};
  pugi::xml_document xml;
  REQUIRE(xml.load_string(junit_xml(suite, {came_out(), red}).c_str()));
  const pugi::xml_node root = xml.child("testsuite");
  CHECK(root.attribute("tests").as_int() == 3);
  CHECK(root.attribute("failures").as_int() == 1);
  CHECK(root.attribute("errors").as_int() == 1);
  const pugi::xml_node two = root.find_child_by_attribute("testcase", "name", "two");
  CHECK(std::string(two.child("failure").attribute("message").value()) == "said \"<b>\" & ?");
  CHECK(std::string(two.child("failure").text().get()).find("more") != std::string::npos);
  CHECK(root.find_child_by_attribute("testcase", "name", "three").child("error"));
  CHECK(metrics_text(suite, {came_out(), red}).find("tactbench_nightly_green{scenario=\"two\"} 0\n") !=
        std::string::npos);
}

TEST_CASE("a suite's numbers have bounds, its names are plain, and a scenario has these defaults") {
  CHECK(refusal(with(kOne, "seed = -1\n")) != "accepted");
  CHECK(refusal(with(kOne, "seed = 0\nsensor_seed = 0\n")) == "accepted");
  CHECK(refusal(with(kOne, "seed = 9007199254740992\nsensor_seed = 9007199254740992\n")) == "accepted");
  CHECK_THAT(refusal(with(kOne, "seed = 1e16\n")), Catch::Contains("from 0 to 9007199254740992"));
  CHECK_THAT(refusal(with(kOne, "sensor_seed = 1e16\n")), Catch::Contains("from 0 to 9007199254740992"));
  CHECK(refusal(with(kOne, "[scenario.taxels]\ndead = [0, 1000000]\n")) == "accepted");
  CHECK_THAT(refusal(with(kOne, "[scenario.taxels]\ndead = [-1]\n")),
             Catch::Contains("taxel -1 is not a whole number"));
  CHECK_THAT(refusal(with(kOne, "[scenario.taxels]\ndead = [1000001]\n")), Catch::Contains("is not a whole number"));
  for (const char* name : {"", "A", "a_b", "a b", "a.b"})
    CHECK_THAT(refusal(fmt::format("{}[[scenario]]\nname = \"{}\"\nabout = \"\"\n", kNightHead, name)),
               Catch::Contains("names a file too"));
  CHECK(refusal(with(kNightHead, "[[scenario]]\nname = \"az-09\"\nabout = \"\"\n")) == "accepted");
  CHECK(refusal("schema = 2\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"\"\n") != "accepted");
  const Scenario scenario = parse_suite(kOne, "s.toml").scenarios.front();
  CHECK(scenario.recipes == std::vector<std::string>{"descending", "ascending"});
  CHECK(scenario.held_out.empty());
  CHECK((scenario.fits && !scenario.own_run && !scenario.void_held_out));
  CHECK((scenario.seed == 1 && scenario.sensor_seed == 1));
  CHECK(scenario.label == "one");
  CHECK(scenario.outcome == "completed");
  CHECK(scenario.safe == "verified");
  const Scenario two =
      parse_suite(with(kOne, "held_out = [\"a=1\"]\nheld_out_2 = []\nvoid_held_out = true\n"), "s.toml")
          .scenarios.front();
  CHECK(two.held_out == std::vector<std::vector<std::string>>{{"a=1"}, {}});
  CHECK(two.void_held_out);
}

TEST_CASE("a suite with several seeds runs each scenario once per seed, counting up from its own seed") {
  const Suite suite = parse_suite(with(kOne, "seed = 5\n[[scenario]]\nname = \"two\"\nabout = \"\"\n"), "s.toml");
  const Suite once = with_seeds(suite, 1);
  REQUIRE(once.scenarios.size() == 2);
  CHECK(once.scenarios[0].label == "one");
  CHECK(once.scenarios[0].seed == 5);
  const Suite many = with_seeds(suite, 3);
  std::vector<std::string> labels;
  for (const Scenario& scenario : many.scenarios) labels.push_back(scenario.label);
  CHECK(labels ==
        std::vector<std::string>{"one-seed-5", "one-seed-6", "one-seed-7", "two-seed-1", "two-seed-2", "two-seed-3"});
  CHECK(many.scenarios[2].seed == 7);
  CHECK(many.scenarios[2].name == "one");
}
