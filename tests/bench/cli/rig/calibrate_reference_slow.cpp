// devices calibrate-reference with a gauge's readings typed in: what it asks, what it makes of them, and its refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"

using namespace tactbench::tests;

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
  std::istringstream lines(file);
  for (std::string line; std::getline(lines, line);) {
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
