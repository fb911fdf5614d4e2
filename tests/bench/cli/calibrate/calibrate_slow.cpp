// `calibrate` as an operator uses it, on the simulated rig: verdicts, exit codes, ways on after a failure.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

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

TEST_CASE("calibrate: a good sensor passes by the shipped limits, with a report and the word in large letters") {
  const TemporaryFolder folder;
  begin_with_profile(folder);
  const Finished done = calibrated(folder, {});
  INFO(done.err << done.out);
  REQUIRE(done.code == 0);
  CHECK_THAT(done.out, Catch::StartsWith("SIMULATED DATA: bench '") &&
                           Catch::Contains("1/5 sensor    MY-1 (PCB piezoresistive 16x16) is new, registered") &&
                           Catch::Contains("2/5 measure   production: run 1: completed, 303 frames") &&
                           Catch::Contains("3/5 held out  random-reversal: run 2: completed, 463 frames") &&
                           Catch::Contains("4/5 fit       dynamic on run 1: 256 of 256 taxels fitted; on run 2 mean") &&
                           Catch::Contains("5/5 report    1-") &&
                           Catch::Contains("SIMULATED  ####   ###   ####  ####\n") &&
                           Catch::Contains("sensor MY-1: simulated pass, under repeatability conditions only: all ") &&
                           Catch::Contains("errors of run 2 hold for random reversals: ") &&
                           Catch::Contains("bad taxels: none\n"));
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
  const Finished done = calibrated(folder, words);
  INFO(done.err);
  REQUIRE(done.code == 1);
  const json result = json::parse(done.out);
  CHECK(result.at("schema") == "tactbench.calibrate");
  CHECK(result.at("registered") == false);
  CHECK(result.at("origin") == "simulated");
  CHECK(result.at("verdict") == "fail");
  CHECK(result.at("shown") == "simulated fail");
  CHECK_THAT(result.at("reason").get<std::string>(), Catch::StartsWith("taxels not modelled: 1 (tolerance limit 0)"));
  REQUIRE(result.at("bad_taxels").size() == 1);
  CHECK(result.at("bad_taxels").at(0) == json{{"row", 2}, {"column", 5}, {"why", "dead"}});
  CHECK(std::filesystem::exists(folder.path(result.at("report").at("path").get<std::string>())));
  // From runs that exist: nothing is measured, the verdict is the same, in large letters.
  const Finished again = calibrated(folder, {"--run", "1", "--held-out", "2"});
  CHECK(again.code == 1);
  CHECK_THAT(again.out,
             Catch::Contains("2/5 measure   run 1 is taken as it is\n3/5 held out  run 2 is taken as it is\n") &&
                 Catch::Contains("SIMULATED  #####  ###  ### #\n") &&
                 Catch::Contains("bad taxels: row 2, column 5 (dead)\n"));
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

TEST_CASE("calibrate: limits that nothing could meet are refused before anything is touched") {
  const TemporaryFolder folder;
  begin_with_profile(folder);
  write_file(folder.path("odd.toml"),
             "schema = 1\nname = \"odd\"\nrule = \"default\"\nmean_compensation_error_psi = 9\n"
             "worst_taxel_error_psi = 9\ndistance_of_mean_percent_fs = 9\nunfit_taxels = 0\n"
             "[[mismatch]]\npressure_psi = 11\nstd_percent_fs = 5\n");
  const auto refused = [&](const std::vector<std::string>& words, const char* id, const char* said) {
    const Finished done = calibrated(folder, words);
    INFO(done.err);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::Contains(id) && Catch::Contains(said));
  };
  refused({"--limits", "odd.toml"}, "[TB-CALIBRATE-LEVELS]", "judge at 11 psi, which random-reversal does not measure");
  refused({"--recipe", "produktion"}, "[TB-FILE-MISSING]", "did you mean 'production'?");
  refused({"--recipe", "ring"}, "[TB-USAGE]", "no models are made from recipes that press objects");
  refused({"--held-out", "2"}, "[TB-USAGE]", "--run");
  refused({"--operator", " "}, "[TB-USAGE]", "--operator is empty");
  CHECK(!std::filesystem::exists(folder.path("runs.db")));
  CHECK_THAT(calibrated(folder, {"--run", "1"}).err, Catch::Contains("[TB-STORE-OPEN]"));
}

TEST_CASE("calibrate: a run that fails is kept, and the error names the commands that complete the calibration") {
  const TemporaryFolder folder;
  begin_with_profile(folder);
  const Finished failed = calibrated(folder, {"--set", R"(simulation.faults=[{kind="scanner_unplugged",at_s=300}])"});
  INFO(failed.err << failed.out);
  REQUIRE(failed.code == 3);
  CHECK_THAT(failed.err,
             Catch::Contains("to continue: tactbench resume 1 --db runs.db, then tactbench calibrate MY-1") &&
                 Catch::Contains("--run 1"));
  CHECK_THAT(failed.out, !Catch::Contains("PASS") && !Catch::Contains("####"));
  CHECK(json::parse(call(folder, {"runs", "show", "1", "--json"}).out).at("outcome") == "failed");
  // Not while it is incomplete, nor with a run of another sensor.
  const Finished early = calibrated(folder, {"--run", "1"});
  CHECK(early.code == 2);
  CHECK_THAT(early.err, Catch::Contains("run 1 did not complete") && Catch::Contains("tactbench resume 1"));
  const Finished other = call(folder, {"calibrate", "MY-2", "-q", "--run", "1"});
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Catch::Contains("run 1 is of sensor 'MY-1', not of 'MY-2'"));
}
