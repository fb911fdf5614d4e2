// A night's results: its exit code, its JSON document and each printed line.
#include "bench/cli/night/nightly.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

Suite suite_of(std::size_t scenarios) {
  Suite suite;
  suite.name = "small";
  suite.scenarios.resize(scenarios);
  return suite;
}

ScenarioResult result_with(const std::vector<std::string>& wrong, const std::vector<std::string>& remarks) {
  ScenarioResult result;
  result.name = "short";
  result.about = "a fit";
  result.seconds = 12.34;
  result.wrong = wrong;
  result.remarks = remarks;
  return result;
}

}  // namespace

TEST_CASE("night results: exit code is 1 for a failed or missing scenario, 6 for changes only, and 1 outranks 6") {
  const ScenarioResult green = result_with({}, {}), moved = result_with({}, {"a"}), red = result_with({"b"}, {}),
                       both = result_with({"b"}, {"a"});
  CHECK(code_of_night(suite_of(2), {green, green}) == ExitCode::kPass);
  CHECK(code_of_night(suite_of(2), {green, moved}) == ExitCode::kInconclusive);
  CHECK(code_of_night(suite_of(2), {red, moved}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(1), {both}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(3), {green, green}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(0), {}) == ExitCode::kPass);
}

TEST_CASE("night results: the JSON document counts the failed scenarios and those that did not run") {
  const nlohmann::ordered_json json =
      night_json(suite_of(4), {result_with({"b"}, {}), result_with({}, {"a"}), result_with({"c"}, {})});
  tests::check_members(json, R"({"suite": "small", "origin": "simulated", "red": 2, "not_run": 1})");
  REQUIRE(json.at("scenarios").size() == 3);
  CHECK(json.at("scenarios").at(0).at("wrong") == nlohmann::json({"b"}));
  CHECK(json.at("scenarios").at(1).at("remarks") == nlohmann::json({"a"}));
  CHECK(json.at("scenarios").at(1).at("seconds") == 12.34);
}

TEST_CASE("night results: only requested files are written, a file of another kind is overwritten on request only") {
  const tests::TemporaryFolder folder;
  Session session;
  const Suite suite = suite_of(1);
  write_night_lists({}, suite, {}, session);
  write_night_page({}, suite, {}, session);
  NightFiles files;
  files.junit = folder.path("night.xml");
  write_night_lists(files, suite, {result_with({}, {})}, session);
  CHECK_THAT(tests::read_file(files.junit), Catch::Contains("tests=\"1\" failures=\"0\""));
  CHECK_FALSE(std::filesystem::exists(folder.path("night.prom")));
  files = {};
  files.metrics = folder.path("night.prom");
  files.html = folder.path("night.html");
  write_night_lists(files, suite, {}, session);
  CHECK_THAT(tests::read_file(files.metrics), Catch::Contains("tactbench"));
  CHECK_FALSE(std::filesystem::exists(files.html));
  write_night_page(files, suite, {}, session);
  CHECK_THAT(tests::read_file(files.html), Catch::Contains("<html"));
  for (std::string NightFiles::*file : {&NightFiles::junit, &NightFiles::metrics, &NightFiles::html}) {
    NightFiles own;
    own.*file = folder.path("diary");
    const auto write = [&] {
      write_night_lists(own, suite, {}, session);
      write_night_page(own, suite, {}, session);
    };
    tests::write_file(own.*file, "dear diary\n");
    session.replace = false;
    CHECK_THROWS_AS(write(), Error);
    session.replace = true;
    CHECK_NOTHROW(write());
    CHECK(tests::read_file(own.*file) != "dear diary\n");
  }
}
