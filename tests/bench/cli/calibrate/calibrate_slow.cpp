// `calibrate` on the simulated rig: what its runs are told, each stage that can fail, verdicts and ways on.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

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
    return call(folder, joined({"calibrate", "MY-1", "--recipe", "./a.toml", "--held-out-recipe", "./b.toml",
                                "--limits", limits, "--model", "elam"},
                               more));
  }
  nlohmann::json printed(const CalibrateWords& words) const { return nlohmann::json::parse(call(folder, words).out); }
  TemporaryFolder folder;
};

// By the shipped recipe and limits, in a folder with a profile: only the serial has to be typed.
Finished calibrated(const TemporaryFolder& folder, const std::vector<std::string>& more) {
  return call(folder, joined({"calibrate", "MY-1", "-q"}, more));
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

// devices calibrate-reference with a gauge's readings typed in: what it asks, what it makes of them, and its refusals.

namespace {

struct TypedReadings {
  TypedReadings() { REQUIRE(run_program(program_path(), {"init"}, folder.path()).code == 0); }
  Finished calibrate(const std::string& typed, const std::string& words) const {
    write_file(folder.path("typed"), typed);
    return run_program(
        "/bin/sh",
        {"-c", std::string(program_path()) +
                   " devices calibrate-reference --bench bench.toml --gauge 'gauge 7' --uncertainty 0.05 " + words +
                   " < typed"},
        folder.path());
  }
  // Vented, without a file.
  void ended(const std::string& typed, const std::string& words, int code, const std::string& id,
             const std::string& place = "calibrate-reference") const {
    const Finished done = calibrate(typed, words + " -o none.toml");
    check_refusal(done, code, id, place);
    CHECK(done.out.empty());
    if (code != 7) CHECK_THAT(done.err, Catch::Contains("vented, verified"));
    CHECK_FALSE(std::filesystem::exists(folder.path("none.toml")));
  }
  std::string file(const std::string& name) const { return read_file(folder.path(name)); }
  TemporaryFolder folder;
};

// A line of the file's record of readings: "#   30.000  down    29.9716    30.0000  -0.0435".
struct Recorded {
  double level = 0.0, reference = 0.0, gauge = 0.0;
  std::string direction;
};
std::vector<Recorded> recorded(const std::string& file) {
  std::vector<Recorded> found;
  for (const std::string& line : lines_of(file)) {
    std::istringstream words(line);
    Recorded one;
    std::string hash;
    if (words >> hash >> one.level >> one.direction >> one.reference >> one.gauge) found.push_back(one);
  }
  return found;
}

}  // namespace

TEST_CASE("calibrate-reference: each level is read with increasing and decreasing pressure") {
  const TypedReadings of;
  const Finished done =
      of.calibrate("0.1\nabc\n30.2\n60.3\n60.2\n206.8427kPa\n0\n", "--levels 0,30,60 --resolution 0.2 -o ref.toml");
  REQUIRE(done.code == 0);
  CHECK_THAT(done.err, Catch::Contains("vented, verified"));

  const std::string file = of.file("ref.toml");
  const std::vector<Recorded> readings = recorded(file);
  REQUIRE(readings.size() == 6);
  const std::vector<double> levels{0, 30, 60, 60, 30, 0}, gauge{0.1, 30.2, 60.3, 60.2, 30.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(readings[i].level == levels[i]);
    CHECK(readings[i].direction == (i < 3 ? "up" : "down"));
    CHECK(readings[i].gauge == Approx(gauge[i]).margin(1e-4));
    CHECK(readings[i].reference == Approx(levels[i]).margin(0.3));
  }
}

TEST_CASE("calibrate-reference: an implausible gauge reading is asked for again") {
  const TypedReadings of;
  // Ten times too much, another level's, the wrong unit, the wrong sign; then the right one.
  REQUIRE(of.calibrate("0\n100.1\n20.1\n69kPa\n10.1\n206.8\n20.1\n-20.1\n20.1\n1.01\n68.9\n10.1\n0\n",
                       "--levels 0,10,20 -o ref.toml")
              .code == 0);
  const std::vector<Recorded> readings = recorded(of.file("ref.toml"));
  REQUIRE(readings.size() == 6);
  for (const Recorded& one : readings) CHECK(std::abs(one.gauge - one.reference) < 0.5);
  of.ended("0\n100.1\n20.1\n20.1\n0.0\n", "--levels 0,10,20", 4, "TB-CALIBRATION-STOPPED");
  // Nothing twice of a reference that reads 4 % too much.
  REQUIRE(
      of.calibrate("0\n20\n60\n60\n20\n0\n", "--levels 0,20,60 --set 'reference.span_psi=[0,104]' -o high.toml").code ==
      0);
  for (const Recorded& one : recorded(of.file("high.toml")))
    CHECK(one.reference == Approx(1.04 * one.gauge).margin(0.3));
}

TEST_CASE("calibrate-reference: with --units kPa readings are typed in kPa, the file stays in psi") {
  const TypedReadings of;
  constexpr double kKilopascals = 6.894757293168361;
  REQUIRE(of.calibrate("0\n206.8\n30psi\n0\n", "--levels 0,30 --units kPa -o k.toml").code == 0);
  const std::vector<Recorded> readings = recorded(of.file("k.toml"));
  REQUIRE(readings.size() == 4);
  CHECK(readings[1].level == 30.0);
  CHECK(readings[1].gauge == Approx(206.8 / kKilopascals).margin(1e-4));
  CHECK(readings[2].gauge == 30.0);
}

TEST_CASE("calibrate-reference: an error or an abort leaves the chamber vented and writes no file") {
  const TypedReadings of;
  for (const char* typed : {"0\nq\n", "0\n"}) of.ended(typed, "--levels 0,30", 4, "TB-CALIBRATION-STOPPED");
  // Levels far closer than the reference's noise.
  of.ended("0\n0\n0\n0\n0\n0\n0\n0\n", "--levels 0,1e-6,2e-6,3e-6,4e-6,5e-6,6e-6,7e-6", 3, "TB-REFERENCE-FLAT");
  of.ended("0\n0\n0\n0\n",
           "--levels 0,30 --set settling.timeout_s=4 --set 'simulation.faults=[{kind=\"valve_stuck\"}]'", 3,
           "TB-CHAMBER-TIMEOUT", "calibrate-reference, chamber");
  // It sticks while the chamber is vented: at this pressure, as long as nothing of the time before changes.
  of.ended("10\n20\n20\n10\n", "--levels 10,20 --set 'simulation.faults=[{kind=\"valve_stuck\",at_s=8}]'", 7,
           "TB-SAFE-UNVERIFIED");
}

TEST_CASE(
    "calibrate-reference: the default file name has the serial of the reference, other files are not overwritten") {
  const TypedReadings of;
  CHECK(of.calibrate("0\n60\n60\n0\n", "--levels 0,60").code == 0);  // the ends of the command limit
  CHECK(std::filesystem::exists(of.folder.path("reference-SIM-REF-1.toml")));
  write_file(of.folder.path("notes"), "mine");
  check_refusal(of.calibrate("0\n30\n30\n0\n", "--levels 0,30 -o notes"), 2, "TB-FILE-EXISTS", "notes");
  CHECK(of.file("notes") == "mine");
  CHECK(of.calibrate("0\n30\n30\n0\n", "--levels 0,30 -o notes --replace").code == 0);
  CHECK(recorded(of.file("notes")).size() == 4);
}

TEST_CASE("calibrate-reference: a signal during the wait for a reading ends it vented, without a file") {
  const TypedReadings of;
  const Finished ended = run_program(
      "/bin/sh",
      {"-c", "mkfifo typed && exec 3<>typed && exec '" + std::string(program_path()) +
                 "' devices calibrate-reference --bench bench.toml --gauge g --uncertainty 0.05 --levels 0,30 -o "
                 "none.toml <&3 2>said"},
      of.folder.path(), {SIGTERM, [&] {
                           return std::filesystem::exists(of.folder.path("said")) &&
                                  of.file("said").find("q ends]: ") != std::string::npos;
                         }});
  CHECK(ended.code == 4);
  CHECK_THAT(of.file("said"), Catch::Contains("[TB-CALIBRATION-STOPPED]") && Catch::Contains("vented, verified"));
  CHECK_FALSE(std::filesystem::exists(of.folder.path("none.toml")));
}

TEST_CASE("calibrate-reference: the JSON document has the corrections of the written file") {
  const TypedReadings of;
  const nlohmann::json printed = nlohmann::json::parse(
      well(of.calibrate("0.1\n30.2\n60.3\n60.2\n30\n0\n", "--levels 0,30,60 -o ref.toml --json")).out);
  CHECK(printed.at("schema") == "tactbench.devices.calibrate-reference");
  CHECK(printed.at("file") == "ref.toml");
  // Each correction is that of the means of its two readings.
  const std::vector<Recorded> readings = recorded(of.file("ref.toml"));
  REQUIRE(readings.size() == 6);
  for (std::size_t i = 0; i < 3; ++i) {
    const double reading = 0.5 * (readings[i].reference + readings[5 - i].reference);
    CHECK(printed.at("reading_psi").at(i).get<double>() == Approx(reading).margin(6e-4));
    CHECK(printed.at("correction_psi").at(i).get<double>() ==
          Approx(0.5 * (readings[i].gauge + readings[5 - i].gauge) - reading).margin(6e-4));
    CHECK(printed.at("expanded_uncertainty_psi").at(i).get<double>() > 0.05);
  }
  CHECK(run_program(program_path(),
                    {"devices", "check", "--bench", "bench.toml", "--set", "reference.correction_file=ref.toml"},
                    of.folder.path())
            .code == 0);
  CHECK(printed.at("largest_residual_psi").get<double>() >= 0.0);
  CHECK(printed.at("hysteresis_psi").get<double>() >= 0.0);
}
