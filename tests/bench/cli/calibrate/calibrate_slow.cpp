// `calibrate` as an operator uses it, on the simulated rig: verdicts, exit codes, ways on after a failure.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// A folder with a profile, in which only the serial has to be typed.
void begin_with_profile(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
}

Finished calibrated(const TemporaryFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"calibrate", "MY-1", "-q"};
  words.insert(words.end(), more.begin(), more.end());
  return call(folder, words);
}

const std::vector<std::string> kOneDeadTaxel = {"--set", R"(simulation.defect=[{kind="dead",row=2,column=5}])"};

}  // namespace

TEST_CASE("calibrate: a good sensor passes by the shipped limits, with a report") {
  const TemporaryFolder folder;
  begin_with_profile(folder);
  const Finished done = calibrated(folder, {});
  INFO(done.err << done.out);
  REQUIRE(done.code == 0);
  CHECK_THAT(read_file(folder.path("reports/run-1.html")), Catch::Contains("SIMULATED"));
  // The same verdict and the same report as by hand.
  const Finished report = call(folder, {"report", "1", "--json"});
  REQUIRE(report.code == 0);
  CHECK_THAT(done.out, Catch::Contains(json::parse(report.out).at("number").get<std::string>()));
  // The held-out run is other data.
  const json first = json::parse(call(folder, {"runs", "show", "1", "--json"}).out);
  const json second = json::parse(call(folder, {"runs", "show", "2", "--json"}).out);
  CHECK(first.at("seed").get<int>() + 1 == second.at("seed").get<int>());
  CHECK(first.at("sensor_seed") == second.at("sensor_seed"));
}

TEST_CASE(
    "calibrate: a dead taxel fails and is named by row and column, and the known sensor is not registered again") {
  const TemporaryFolder folder;
  begin_with_profile(folder);
  REQUIRE(call(folder, {"sensors", "add", "MY-1"}).code == 0);
  std::vector<std::string> words = kOneDeadTaxel;
  words.emplace_back("--json");
  const json result = json::parse(well(calibrated(folder, words), 1).out);
  CHECK(result.at("schema") == "tactbench.calibrate");
  CHECK(result.at("registered") == false);
  CHECK(result.at("origin") == "simulated");
  CHECK(result.at("verdict") == "fail");
  CHECK(result.at("shown") == "simulated fail");
  REQUIRE(result.at("bad_taxels").size() == 1);
  CHECK(result.at("bad_taxels").at(0) == json{{"row", 2}, {"column", 5}, {"why", "dead"}});
  CHECK(std::filesystem::exists(folder.path(result.at("report").at("path").get<std::string>())));
  // From runs that exist: nothing is measured, the verdict is the same.
  CHECK(calibrated(folder, {"--run", "1", "--held-out", "2"}).code == 1);
  CHECK(json::parse(call(folder, {"runs", "list", "--json"}).out).at("runs").size() == 2);
}

TEST_CASE(
    "calibrate: the shipped recipe and limits pass good sensors, not only conditionally, and few repeats keep k "
    "small") {
  // Sensors that nothing was chosen on.
  for (const char* seed : {"71", "72"}) {
    const TemporaryFolder folder;
    begin_with_profile(folder);
    const Finished done = calibrated(folder, {"--sensor-seed", seed, "--seed", seed, "--json"});
    INFO(seed << done.err);
    const json result = json::parse(done.out);
    for (const json& row : result.at("verdicts")) {
      INFO(row);
      if (row.at("criterion") != "worst_taxel_error") CHECK(row.at("verdict") == "pass");  // that is the sensor's
    }
  }
  // Two repeats have four full sweeps a branch, and 256 taxels.
  const TemporaryFolder folder;
  begin_with_profile(folder);
  (void)calibrated(folder, {"--sensor-seed", "71", "--set", "recipe.repeats=2"});
  (void)call(folder, {"report", "1", "--format", "json", "-o", "r.json"});
  const json data = json::parse(read_file(folder.path("r.json")));
  const json& figures = data.at("sections").at("uncertainty").at("judged_figures");
  REQUIRE(figures.size() > 4);
  for (const json& figure : figures) {
    INFO(figure);
    if (figure.at("not_known") == "") CHECK(figure.at("factor").get<double>() < 4.6);
  }
}
