// What a suite file is refused for, in all its words with what to do, and each key that a scenario takes.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "bench/nightly/scenario.h"
#include "bench/nightly/suite.h"
#include "sequences/toml/strict_toml.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

const std::string kOneScenario = "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\n";

// "what | remedy", or "accepted".
std::string suite_refusal(const std::string& more, const std::string& begin = kOneScenario) {
  try {
    (void)parse_suite(begin + more, "s.toml");
  } catch (const sequences::FileError& error) {
    return fmt::format("{} | {}", error.what(), error.remedy());
  }
  return "accepted";
}

}  // namespace

TEST_CASE("suite refusals: each rule with its words and its remedy") {
  CHECK(suite_refusal("[scenario.taxels]\ndead = [1.5]\n") ==
        "taxel 1.5 is not a whole number from 0 | taxel = row x columns + column");
  CHECK(suite_refusal("[[scenario]]\nname = \"one\"\nabout = \"again\"\n") ==
        "two scenarios are named 'one' | rename one of them");
  CHECK(suite_refusal("", "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"A\"\nabout = \"\"\n") ==
        "'A' names a file too | use small letters, digits and hyphens");
  CHECK(suite_refusal("[scenario.taxels]\nbroken = [1]\n") ==
        "'broken' is not a taxel's status | use one of: dead, stuck, saturated, unfit");
  const std::string fits = "verdicts and taxels come from a fit, and fits = false | omit them, or remove fits = false";
  CHECK(suite_refusal("fits = false\n[scenario.taxels]\ndead = [1]\n") == fits);
  CHECK(suite_refusal("fits = false\nown_run = true\n[scenario.verdicts]\nmismatch = \"pass\"\n") == fits);
  CHECK(suite_refusal("fits = false\n[scenario.figures]\nframes = [1, 2]\n") == "accepted");
  CHECK(suite_refusal("own_run = true\nheld_out = []\n") == "own_run and held_out cannot be combined | leave one out");
  CHECK(suite_refusal("[scenario.verdicts]\nmismatch = \"pass\"\n") ==
        "there is no run to be judged except the fit's own | add held_out, or own_run = true to judge the own figures");
  CHECK(suite_refusal("void_held_out = true\n") == "there is no held-out run to be declared void | add held_out");
  CHECK(suite_refusal("", "schema = 1\nname = \"s\"\n") == "the suite has no scenario | add [[scenario]]");
  CHECK(suite_refusal("outcome = \"lost\"\n") != "accepted");
  CHECK(suite_refusal("safe = \"lost\"\n") != "accepted");
  CHECK(suite_refusal("[scenario.verdicts]\nmismatch = \"lost\"\n") != "accepted");
  for (const char* unknown : {"x = 1\n", "[scenario.figures]\nframes = 1\n"})
    CHECK(suite_refusal(unknown) != "accepted");
  CHECK(suite_refusal("", "x = 1\n" + kOneScenario) != "accepted");
}

TEST_CASE("suite keys: every one of a scenario as it is written") {
  const Suite suite = parse_suite(
      kOneScenario +
          "bench = \"b.toml\"\nrecipes = [\"r\", \"q\"]\nset = [\"a=1\", \"b=2\"]\nheld_out = [\"c=3\"]\nlimits = "
          "\"l.toml\"\nseed = 5\nsensor_seed = 6\noutcome = \"stopped\"\nerror = \"TB-X\"\nsafe = "
          "\"unverified\"\n[scenario.taxels]\ndead = [4, 3]\nunfit = []\n[scenario.verdicts]\noverall = "
          "\"fail\"\n[scenario.figures]\nframes = [1, 2.5]\n",
      "s.toml");
  CHECK(suite.name == "s");
  CHECK(suite.file == "s.toml");
  CHECK(suite.text.starts_with(kOneScenario));
  const Scenario& one = suite.scenarios.at(0);
  CHECK(one.about == "first");
  CHECK(one.bench == "b.toml");
  CHECK(one.recipes == std::vector<std::string>{"r", "q"});
  CHECK(one.set == std::vector<std::string>{"a=1", "b=2"});
  CHECK(one.held_out == std::vector<std::vector<std::string>>{{"c=3"}});
  CHECK(one.limits == "l.toml");
  CHECK((one.seed == 5 && one.sensor_seed == 6));
  CHECK(one.outcome == "stopped");
  CHECK(one.error == "TB-X");
  CHECK(one.safe == "unverified");
  CHECK(one.taxels == std::map<std::string, std::vector<int>>{{"dead", {3, 4}}, {"unfit", {}}});
  CHECK(one.verdicts == std::map<std::string, std::string>{{"overall", "fail"}});
  CHECK(one.figures.at("frames") == std::pair(1.0, 2.5));
  const Suite own = parse_suite(kOneScenario + "own_run = true\nfits = true\n", "s.toml");
  CHECK(own.scenarios[0].own_run);
  CHECK(own.scenarios[0].bench == "simulated.toml");
  CHECK(own.scenarios[0].limits == "nightly-limits.toml");
}

TEST_CASE("differences: each part of a scenario's end, each list of taxels, and figures at their edges") {
  Scenario scenario;
  scenario.error = "TB-X";
  ScenarioResult result;
  result.runs = {{1, "failed", "TB-OLD", "failed", ""}, {2, "aborted", "", "unverified", ""}};
  result.taxels = {{"dead", {7}}};
  const auto lines = [&] { return differences(scenario, result); };
  using SuiteLines = std::vector<std::string>;
  // The taxels of a run that did not complete say nothing.
  CHECK(lines() == SuiteLines{"the outcome is aborted, must be completed", "the error is none, must be TB-X",
                              "the safe state is unverified, must be verified"});
  scenario.error.clear();
  result.runs.back() = {2, "completed", "", "verified", ""};
  result.taxels = {{"dead", {7}}, {"stuck", {1, 2}}, {"saturated", {3}}, {"unfit", {4}}};
  CHECK(lines() ==
        SuiteLines{"the list of dead taxels is 7, must be none", "the list of stuck taxels is 1, 2, must be none",
                   "the list of saturated taxels is 3, must be none", "the list of unfit taxels is 4, must be none"});
  scenario.fits = false;
  CHECK(lines().empty());
  scenario.figures = {{"a", {1.0, 2.0}}};
  for (const double inside : {1.0, 1.5, 2.0}) {
    result.figures = {{"a", inside}};
    CHECK(lines().empty());
  }
  for (const double outside : {0.5, 2.5, std::numeric_limits<double>::infinity()}) {
    result.figures = {{"a", outside}};
    CHECK(lines() == SuiteLines{fmt::format("a is {:.6g}, must lie in 1 to 2", outside)});
  }
  scenario.figures.clear();
  scenario.verdicts = {{"mismatch", "pass"}, {"mis", "pass"}};
  result.verdicts = {{"mismatch", "fail"}, {"mismatch 4 psi", "pass"}, {"mismatched", "fail"}};
  CHECK(lines() ==
        SuiteLines{"there is no verdict by mis, must be pass", "the verdict on mismatch is fail, must be pass"});
}

TEST_CASE("a scenario's result as JSON: every member there and back, numbers that are none among them") {
  ScenarioResult result;
  result.name = "n";
  result.about = "a";
  result.wrong = {"w", "x"};
  result.remarks = {"r"};
  result.compared = "c";
  result.runs = {{3, "completed", "TB-X", "verified", "ab"}, {4, "failed", "", "failed", "cd"}};
  result.figures = {{"f", 1.5}, {"g", std::numeric_limits<double>::quiet_NaN()}};
  result.verdicts = {{"v", "pass"}};
  result.taxels = {{"dead", {1, 2}}};
  result.seconds = 2.5;
  const std::string text = to_json(result);
  CHECK(text ==
        R"({"name":"n","about":"a","wrong":["w","x"],"remarks":["r"],"compared":"c","figures":{"f":1.5,"g":null},)"
        R"("verdicts":{"v":"pass"},"taxels":{"dead":[1,2]},"seconds":2.5,"runs":[{"run":3,"outcome":"completed",)"
        R"("error":"TB-X","safe":"verified","content_sha256":"ab"},{"run":4,"outcome":"failed","error":"",)"
        R"("safe":"failed","content_sha256":"cd"}]})");
  const ScenarioResult back = result_from_json(text);
  CHECK(to_json(back) == text);
  CHECK(back.figures.at("g") != back.figures.at("g"));
  CHECK(back.runs[1].run == 4);
  CHECK_THROWS_WITH(result_from_json("{}"), Catch::StartsWith("a scenario's result cannot be read: "));
}
