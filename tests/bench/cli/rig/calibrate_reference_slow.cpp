// devices calibrate-reference with a gauge's readings typed in: what it asks, what it makes of them, and its refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/paths.h"
#include "tests/support/process.h"

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

std::string fixed(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

constexpr const char* kAskedThree[] = {" 1 of 6: 0 psi, increasing. ",  " 2 of 6: 30 psi, increasing. ",
                                       " 3 of 6: 60 psi, increasing. ", " 4 of 6: 60 psi, decreasing. ",
                                       " 5 of 6: 30 psi, decreasing. ", " 6 of 6: 0 psi, decreasing. "};

}  // namespace

TEST_CASE("calibrate-reference: each level is asked for on the way up and down, and the corrections are the means'") {
  const TypedReadings of;
  const Finished done =
      of.calibrate("0.1\nabc\n30.2\n60.3\n60.2\n206.8427kPa\n0\n", "--levels 0,30,60 --resolution 0.2 -o ref.toml");
  REQUIRE(done.code == 0);
  std::string asked;
  for (const char* question : kAskedThree) {
    asked += std::string(question) + "Hand gauge reads [psi, q ends]: ";
    if (question == kAskedThree[1])
      asked += "'abc' is not a pressure; the gauge's reading in psi, or with its own unit, or q to end\n" +
               std::string(question) + "Hand gauge reads [psi, q ends]: ";
  }
  CHECK(done.err == asked + "vented, verified (feedback 0.0 psi, reference 0.0 psi)\n");

  const std::string file = of.file("ref.toml");
  CHECK_THAT(file, Catch::StartsWith("# SIMULATED correction of ") &&
                       Catch::Contains(" against hand gauge 'gauge 7' (U 0.05 psi, k = 2, resolution 0.2 psi), 20"));
  const std::vector<Recorded> readings = recorded(file);
  REQUIRE(readings.size() == 6);
  const std::vector<double> levels{0, 30, 60, 60, 30, 0}, gauge{0.1, 30.2, 60.3, 60.2, 30.0, 0.0};
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(readings[i].level == levels[i]);
    CHECK(readings[i].direction == (i < 3 ? "up" : "down"));
    CHECK(readings[i].gauge == Approx(gauge[i]).margin(1e-4));
    CHECK(readings[i].reference == Approx(levels[i]).margin(0.3));
  }
  // A line of the table for each level.
  std::istringstream lines(done.out);
  std::string line;
  std::getline(lines, line);
  CHECK(line == "   reading   correction  U (k=2)");
  for (std::size_t i = 0; i < 3; ++i) {
    const double reading = 0.5 * (readings[i].reference + readings[5 - i].reference);
    const double correction = 0.5 * (gauge[i] + gauge[5 - i]) - reading;
    std::string shown, corrected, u, unit;
    std::getline(lines, line);
    std::istringstream(line) >> shown >> corrected >> u >> unit;
    CHECK(std::stod(shown) == Approx(reading).margin(6e-4));
    CHECK(std::stod(corrected) == Approx(correction).margin(6e-4));
    CHECK(corrected[0] == (correction < 0.0 ? '-' : '+'));
    CHECK(std::stod(u) > 0.05);
    CHECK(unit == "psi");
    CHECK(line.size() == 10 + 1 + 12 + 1 + 8 + 2 + 3);
  }
  std::getline(lines, line);
  CHECK_THAT(line,
             Catch::StartsWith("largest residual 0.") && Catch::Contains(" psi; increasing and decreasing differ by "));
  std::getline(lines, line);
  CHECK(line == "ref.toml written (in psi); to use it: [reference] correction_file = \"ref.toml\"");
}

TEST_CASE("calibrate-reference: in kPa it asks, reads and prints in kPa, and the file keeps psi") {
  const TypedReadings of;
  constexpr double kKilopascals = 6.894757293168361;
  const Finished done = of.calibrate("0\n206.8\n30psi\n0\n", "--levels 0,30 --units kPa -o k.toml");
  REQUIRE(done.code == 0);
  CHECK_THAT(done.err,
             Catch::StartsWith(" 1 of 4: 0 kPa, increasing. Hand gauge reads [kPa, q ends]:  2 of 4: 206.8 kPa, "
                               "increasing. Hand gauge reads [kPa, q ends]: "));
  const std::vector<Recorded> readings = recorded(of.file("k.toml"));
  REQUIRE(readings.size() == 4);
  CHECK(readings[1].level == 30.0);
  CHECK(readings[1].gauge == Approx(206.8 / kKilopascals).margin(1e-4));
  CHECK(readings[2].gauge == 30.0);
  const double reading = kKilopascals * 0.5 * (readings[1].reference + readings[2].reference);
  CHECK_THAT(done.out,
             Catch::Contains("\n" + std::string(10 - fixed(reading, 2).size(), ' ') + fixed(reading, 2) + " ") &&
                 Catch::Contains("  kPa\n") && Catch::Contains("k.toml written (in psi)"));
}

TEST_CASE("calibrate-reference: q and the end of the input end it vented, without a file") {
  const TypedReadings of;
  const std::vector<std::pair<std::string, std::string>> ends{{"0\nq\n", "ended by the operator"},
                                                              {"0\n", "the input ended before the last reading"}};
  for (const auto& [typed, why] : ends) {
    const Finished ended = of.calibrate(typed, "--levels 0,30 -o none.toml");
    CHECK(ended.code == 4);
    CHECK_THAT(ended.err, Catch::Contains("error: " + why + " [TB-CALIBRATION-STOPPED]\n  at: calibrate-reference\n") &&
                              Catch::Contains("\n  state: vented, verified ("));
    CHECK_FALSE(std::filesystem::exists(of.folder.path("none.toml")));
  }
}

TEST_CASE("calibrate-reference: levels that do not rise, or lie beyond the command limit, touch no device") {
  const TypedReadings of;
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"0,20,20", "20"}, {"0,20,10", "10"}, {"0,60.5", "60.5"}, {"-0.5,5", "-0.5"}};
  for (const auto& [levels, named] : wrong) {
    const Finished refused = of.calibrate("", "--levels=" + levels);
    CHECK(refused.code == 2);
    CHECK(refused.err ==
          "error: level " + named +
              " psi does not rise, or is beyond 0 to 60 psi [TB-USAGE]\n  at: --levels\n  try: give rising "
              "levels within the command limit\n  state: no device was touched\n");
  }
  const Finished alone = of.calibrate("", "--levels 30");
  CHECK(alone.code == 2);
  CHECK_THAT(alone.err, Catch::StartsWith("error: a calibration needs readings at two levels or more [TB-USAGE]\n") &&
                            Catch::Contains("\n  state: no device was touched\n"));
  // Both ends are levels.
  CHECK(of.calibrate("0\n60\n60\n0\n", "--levels 0,60 -o ends.toml").code == 0);
}

TEST_CASE("calibrate-reference: the file's name comes from the reference's serial, and no other file is overwritten") {
  const TypedReadings of;
  CHECK_THAT(of.calibrate("0\n30\n30\n0\n", "--levels 0,30").out,
             Catch::Contains("\nreference-SIM-REF-1.toml written (in psi); to use it: "));
  CHECK(of.calibrate("0\n30\n30\n0\n", "--levels 0,30 -q").code == 2);  // it has no such option
  write_file(of.folder.path("notes"), "mine");
  const Finished refused = of.calibrate("0\n30\n30\n0\n", "--levels 0,30 -o notes");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("\n  at: notes\n"));
  CHECK(of.file("notes") == "mine");
  CHECK(of.calibrate("0\n30\n30\n0\n", "--levels 0,30 -o notes --replace").code == 0);
  CHECK(recorded(of.file("notes")).size() == 4);
}

TEST_CASE("calibrate-reference: a reference that does not rise ends it vented at that level, before more is asked") {
  const TypedReadings of;
  // Levels far closer than the reference's noise.
  const Finished ended =
      of.calibrate("0\n0\n0\n0\n0\n0\n0\n0\n", "--levels 0,1e-6,2e-6,3e-6,4e-6,5e-6,6e-6,7e-6 -o flat.toml");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err,
             Catch::Contains("\nerror: the reference's reading does not rise with the pressure: ") &&
                 Catch::Contains(" psi at the next level [TB-REFERENCE-FLAT]\n  at: calibrate-reference\n") &&
                 Catch::Contains("\n  state: vented, verified (") && !Catch::Contains("decreasing"));
  CHECK_FALSE(std::filesystem::exists(of.folder.path("flat.toml")));
}

TEST_CASE("calibrate-reference: a level that is not reached ends it vented, with the last reading") {
  const TypedReadings of;
  const Finished ended = of.calibrate(
      "0\n0\n0\n0\n",
      "--levels 0,30 -o none.toml --set settling.timeout_s=4 --set 'simulation.faults=[{kind=\"valve_stuck\"}]'");
  CHECK(ended.code == 3);
  CHECK_THAT(
      ended.err,
      Catch::Contains("error: 30 psi not reached within 4 s; feedback ") &&
          Catch::Contains(
              " psi [TB-CHAMBER-TIMEOUT]\n  at: calibrate-reference, chamber\n  try: check supply and leaks\n") &&
          Catch::Contains("\n  state: vented, verified (") && !Catch::Contains(" 3 of 4"));
  CHECK_FALSE(std::filesystem::exists(of.folder.path("none.toml")));
}

TEST_CASE("calibrate-reference: what cannot be vented after the last reading is told, and no file is written") {
  const TypedReadings of;
  // It sticks while the chamber is vented: at this pressure, as long as nothing of the time before changes.
  const Finished ended = of.calibrate("10\n20\n20\n10\n",
                                      "--levels 10,20 -o none.toml --set 'simulation.faults=[{kind=\"valve_stuck\","
                                      "at_s=8}]'");
  CHECK(ended.code == 7);
  CHECK(ended.out.empty());
  CHECK_THAT(
      ended.err,
      Catch::EndsWith("error: the safe state could not be proved [TB-SAFE-UNVERIFIED]\n  at: calibrate-reference\n"
                      "  try: read the chamber's own gauge before touching the rig\n  state: NOT SAFE: pressure "
                      "remains (feedback 4.2 psi, reference 4.0 psi)\n"));
  CHECK_FALSE(std::filesystem::exists(of.folder.path("none.toml")));
}

TEST_CASE("calibrate-reference: a signal while it waits for a reading ends it vented, without a file") {
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
  CHECK_THAT(of.file("said"), Catch::Contains("error: stopped by a signal [TB-CALIBRATION-STOPPED]\n  at: "
                                              "calibrate-reference\n  try: nothing was written; start again when "
                                              "ready\n  state: vented, verified ("));
  CHECK_FALSE(std::filesystem::exists(of.folder.path("none.toml")));
}

TEST_CASE("calibrate-reference: as JSON it tells what the file has") {
  const TypedReadings of;
  const Finished done = of.calibrate("0.1\n30.2\n60.3\n60.2\n30\n0\n", "--levels 0,30,60 -o ref.toml --json");
  REQUIRE(done.code == 0);
  const nlohmann::json told = nlohmann::json::parse(done.out);
  CHECK(told.at("schema") == "tactbench.devices.calibrate-reference");
  CHECK(told.at("file") == "ref.toml");
  const std::string file = of.file("ref.toml");
  const auto listed = [&](const char* key) {
    std::string text = "\n" + std::string(key) + " = [";
    for (std::size_t i = 0; i < 3; ++i) text += (i == 0 ? "" : ", ") + fixed(told.at(key).at(i).get<double>(), 4);
    return text + "]\n";
  };
  for (const char* key : {"reading_psi", "correction_psi", "expanded_uncertainty_psi"}) {
    CHECK(told.at(key).size() == 3);
    CHECK_THAT(file, Catch::Contains(listed(key)));
  }
  CHECK_THAT(file, Catch::Contains("\n# largest residual " + fixed(told.at("largest_residual_psi").get<double>(), 4) +
                                   " psi, largest difference between up and down " +
                                   fixed(told.at("hysteresis_psi").get<double>(), 4) + " psi\n"));
}
