// `calibrate` on the simulated rig: what its runs are told, each stage that can fail, verdicts and ways on.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/small_bench.h"

using namespace tactbench::tests;

namespace {

using CalibrateWords = std::vector<std::string>;

struct CalibrationFolder {
  CalibrationFolder() {
    REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
    std::filesystem::remove(folder.path("sensor.toml"));  // the shipped one serves
    write_file(folder.path("a.toml"), small_loop_text(10));
    write_file(folder.path("b.toml"), small_loop_text(10).replace(small_loop_text(10).find("1.0"), 3, "1.5"));
    write_file(folder.path("wide.toml"), limits_text("simple", 60));
    write_file(folder.path("only.toml"), limits_text("report-only", 60));
  }
  Finished calibrate(const CalibrateWords& more, const std::string& limits = "./wide.toml") const {
    return call(folder, joined_arguments({"calibrate", "MY-1", "--recipe", "./a.toml", "--held-out-recipe", "./b.toml",
                                          "--limits", limits, "--model", "elam"},
                                         more));
  }
  nlohmann::json printed(const CalibrateWords& words) const { return nlohmann::json::parse(call(folder, words).out); }
  TemporaryFolder folder;
};

// By the shipped recipe and limits, in a folder with a profile: only the serial has to be typed.
Finished calibrated(const TemporaryFolder& folder, const std::vector<std::string>& more) {
  return call(folder, joined_arguments({"calibrate", "MY-1", "-q"}, more));
}

}  // namespace

TEST_CASE("calibrate: both runs get the options of the command line, the second run gets a different seed") {
  const CalibrationFolder of;
  well(of.calibrate({"--no-seating", "--lot", "A7", "--order", "55", "--meta", "film=B12", "--seed", "40",
                     "--sensor-seed", "8", "--set", "recipe.step=20", "--set", "simulation.temperature_c=24",
                     "--on-event", "echo $TACTBENCH_EVENT >> events"}));
  const nlohmann::json first = of.printed({"runs", "show", "1", "--json"}),
                       second = of.printed({"runs", "show", "2", "--json"});
  const nlohmann::json fits = first.at("models");
  REQUIRE(fits.size() == 1);
  CHECK(second.at("models").empty());
  CHECK(fits.at(0).at("kind") == "elam");
  const nlohmann::json report = of.printed({"report", "1", "--json"});
  CHECK(report.at("path") == "reports/run-1.html");
  for (const nlohmann::json* run : {&first, &second}) {
    INFO(*run);
    CHECK(run->at("operator") == "tester");
    CHECK(run->at("sensor") == "MY-1");
    CHECK(run->at("bench") == "simulated-rig");
    CHECK(run->at("sensor_seed") == 8);
    CHECK(run->at("metadata") == nlohmann::json{{"film", "B12"}, {"lot", "A7"}, {"order", "55"}});
  }
  CHECK((first.at("seed") == 40 && second.at("seed") == 41));
  CHECK(first.at("overrides") == nlohmann::json::parse(R"([{"key": "recipe.step", "value": "20"},
                                                 {"key": "simulation.temperature_c", "value": "24"}])"));
  CHECK(second.at("overrides") == nlohmann::json::parse(R"([{"key": "simulation.temperature_c", "value": "24"}])"));
  CHECK(read_file(of.folder.path("events")) == "done\ndone\n");
}

TEST_CASE("calibrate: --json prints only the document, for a registered sensor and limits without requirements") {
  const CalibrationFolder of;
  REQUIRE(call(of.folder, {"sensors", "add", "MY-1"}).code == 0);
  const nlohmann::json document = nlohmann::json::parse(well(of.calibrate({"--json"}, "./only.toml")).out);
  CHECK(document.at("registered") == false);
  CHECK((document.at("run") == 1 && document.at("held_out") == 2));
  check_members(document, R"({"limits": "of-a-test", "origin": "simulated", "model": "elam"})");
  CHECK(document.at("verdicts").size() == 4);
  CHECK(document.at("judgement").is_object());
  CHECK(document.at("report").at("path") == "reports/run-1.html");
  CHECK(document.at("report").at("number").get<std::string>().starts_with("1-"));
  CHECK(of.calibrate({"--run", "1", "--held-out", "2", "--units", "kPa"}, "./only.toml").code == 0);
}

TEST_CASE("calibrate: a failed first or second run ends it with the exit code of that run, vented") {
  const CalibrationFolder of;
  const std::string fault = R"(simulation.faults=[{kind="scanner_unplugged",at_s=20}])";
  const Finished first = of.calibrate({"--no-seating", "--set", fault});
  CHECK(first.code == 3);
  CHECK_THAT(first.err, Catch::Contains("vented, verified"));
  REQUIRE(call(of.folder, {"run", "./a.toml", "--bench", "bench.toml", "--sensor", "MY-1", "-q"}).code == 0);
  CHECK(of.calibrate({"--no-seating", "--set", fault, "--run", "2"}).code == 3);
  // A badly seated sensor is measured again: that run is not worth completing.
  const std::string turn = "simulation.mount_turn=\"turned-90\"";
  check_refusal(of.calibrate({"--set", turn}), 1, "TB-SEATING");
  CHECK(of.calibrate({"--set", turn, "--run", "2"}).code == 1);
}

TEST_CASE("calibrate: an unwritable report ends it with exit code 2, with new runs and with existing runs") {
  const CalibrationFolder of;
  write_file(of.folder.path("reports"), "no folder");
  const Finished written = of.calibrate({});
  CHECK(written.code == 2);
  CHECK_THAT(written.out, !Catch::Contains("5/5"));
  CHECK(of.calibrate({"--run", "1", "--held-out", "2"}).code == 2);
  CHECK(of.calibrate({"--run", "1"}).code == 2);
}

TEST_CASE("calibrate: its model equals the model that fit makes of the same run without verification, bit for bit") {
  const TemporaryFolder with, without;
  for (const TemporaryFolder* folder : {&with, &without}) well(call(*folder, {"init", "--operator", "tester"}));
  (void)calibrated(with, {"--minutes", "13", "--no-seating"});  // the shorter form, whatever its verdict
  well(call(with, {"model", "export", "1", "-o", "model.json"}));
  well(call(without, {"sensors", "add", "MY-1"}));
  well(call(without, {"run", "production-short", "--sensor", "MY-1", "--no-seating", "-q"}));
  well(call(without, {"fit", "1", "-o", "model.json", "-q"}));
  const auto model = [](const TemporaryFolder& folder) {
    return nlohmann::json::parse(read_file(folder.path("model.json")));
  };
  REQUIRE(model(with).at("taxels").size() >= 256);
  CHECK(model(with).at("taxels") == model(without).at("taxels"));
  CHECK(model(with).at("dynamics") == model(without).at("dynamics"));
}

TEST_CASE("calibrate: a good sensor passes by the shipped limits, with a report") {
  const TemporaryFolder folder;
  well(call(folder, {"init", "--operator", "tester"}));
  const Finished done = well(calibrated(folder, {}));
  CHECK_THAT(read_file(folder.path("reports/run-1.html")), Catch::Contains("SIMULATED"));
  // The same verdict and the same report as by hand.
  const auto report = nlohmann::json::parse(well(call(folder, {"report", "1", "--json"})).out);
  CHECK_THAT(done.out, Catch::Contains(report.at("number").get<std::string>()));
}

TEST_CASE("calibrate: a dead taxel fails, listed by row and column, and a registered sensor is not registered again") {
  const TemporaryFolder folder;
  well(call(folder, {"init", "--operator", "tester"}));
  REQUIRE(call(folder, {"sensors", "add", "MY-1"}).code == 0);
  const nlohmann::json result = nlohmann::json::parse(
      well(calibrated(folder, {"--json", "--set", R"(simulation.defect=[{kind="dead",row=2,column=5}])"}), 1).out);
  check_members(result, R"({"schema": "tactbench.calibrate", "registered": false, "origin": "simulated",
                            "verdict": "fail", "shown": "simulated fail"})");
  REQUIRE(result.at("bad_taxels").size() == 1);
  CHECK(result.at("bad_taxels").at(0) == nlohmann::json{{"row", 2}, {"column", 5}, {"why", "dead"}});
  CHECK(std::filesystem::exists(folder.path(result.at("report").at("path").get<std::string>())));
  // From runs that exist: nothing is measured, the verdict is the same.
  CHECK(calibrated(folder, {"--run", "1", "--held-out", "2"}).code == 1);
  CHECK(nlohmann::json::parse(call(folder, {"runs", "list", "--json"}).out).at("runs").size() == 2);
}

TEST_CASE("calibrate: with the shipped recipe and limits good sensors pass, and two repeats keep k small") {
  // Sensors that nothing was chosen on.
  for (const char* seed : {"71", "72"}) {
    const TemporaryFolder folder;
    well(call(folder, {"init", "--operator", "tester"}));
    const Finished done = calibrated(folder, {"--sensor-seed", seed, "--seed", seed, "--json"});
    INFO(seed << done.err);
    const nlohmann::json result = nlohmann::json::parse(done.out);
    for (const nlohmann::json& row : result.at("verdicts")) {
      INFO(row);
      if (row.at("criterion") != "worst_taxel_error") CHECK(row.at("verdict") == "pass");  // that is the sensor's
    }
  }
  // Two repeats have four full sweeps a branch, and 256 taxels.
  const TemporaryFolder folder;
  well(call(folder, {"init", "--operator", "tester"}));
  (void)calibrated(folder, {"--sensor-seed", "71", "--set", "recipe.repeats=2"});
  (void)call(folder, {"report", "1", "--format", "json", "-o", "r.json"});
  const nlohmann::json data = nlohmann::json::parse(read_file(folder.path("r.json")));
  const nlohmann::json& figures = data.at("sections").at("uncertainty").at("judged_figures");
  REQUIRE(figures.size() > 4);
  for (const nlohmann::json& figure : figures) {
    INFO(figure);
    if (figure.at("not_known") == "") CHECK(figure.at("factor").get<double>() < 4.6);
  }
}
