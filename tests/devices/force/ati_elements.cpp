// What a .cal file is refused for, element by element: each that has to be there, each number for itself.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "devices/force/ati_calibration.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/invented_calibration.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

// What the refusal is about; empty: there is none.
void check_calibration(const std::string& text, const std::string& about) {
  INFO(text);
  const auto read = [&] { (void)parse_ati_calibration(text, "test.cal"); };
  if (about.empty()) CHECK_NOTHROW(read());
  if (!about.empty()) check_fault(read, "TB-FORCE-CALIBRATION", "force sensor", about);
}

struct Exchange {
  std::string from, to, about;
};

void check_exchanges(const std::vector<Exchange>& all) {
  for (const Exchange& one : all) {
    std::string text = InventedCalibration().text();
    REQUIRE(text.find(one.from) != std::string::npos);
    check_calibration(text.replace(text.find(one.from), one.from.size(), one.to), one.about);
  }
}

void check_more(const std::string& more, const std::string& about) {
  InventedCalibration invented;
  invented.more = more;
  check_calibration(invented.text(), about);
}

const std::string kNames[6] = {"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};

std::string user_axes_without(std::size_t absent) {
  std::string axes;
  for (std::size_t i = 0; i < 6; ++i) {
    if (i != absent) axes += "<UserAxis Name=\"" + kNames[i] + R"(" values="1 2 3 4 5 6" max="1"/>)";
  }
  return axes;
}

}  // namespace

TEST_CASE("calibration refused: without each attribute that has to be there, or with an empty one") {
  for (const auto& [name, value] : std::vector<std::pair<std::string, std::string>>{{"Serial", "FT99901"},
                                                                                    {"BodyStyle", "Nano17"},
                                                                                    {"NumGages", "6"},
                                                                                    {"CalFileVersion", "1.0"},
                                                                                    {"PartNumber", "SI-50-0.5"},
                                                                                    {"CalDate", "2/30/2020"},
                                                                                    {"ForceUnits", "N"},
                                                                                    {"TorqueUnits", "N-mm"},
                                                                                    {"DistUnits", "mm"},
                                                                                    {"Name", "Fx"},
                                                                                    {"max", "70"}}) {
    const std::string whole = name + "=\"" + value + "\"";
    check_exchanges({{whole, "", name}, {whole, name + "=\"\"", name}});
  }
  check_exchanges({{"values=", "vals=", "values"},
                   {"scale=\"5.5\"", "scale=\"\"", "scale"},
                   {"Family=\"DAQ\"", "", ""},
                   {" scale=\"5.5\"", "", ""}});  // then it is 1
}

TEST_CASE("calibration refused: each axis has to be there, once, by its name") {
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string named = "Axis Name=\"" + kNames[i] + "\"", other = kNames[(i + 1) % 6];
    check_exchanges({{named, "Extra Name=\"x\"", kNames[i]},
                     {named, "Axis Name=\"f\"", "'f'"},
                     {named, "Axis Name=\"" + other + "\"", other}});
    check_more(user_axes_without(i), kNames[i]);
  }
  check_more(user_axes_without(6), "");
}

TEST_CASE("calibration refused: each number is a number, in its bounds") {
  check_exchanges({{"scale=\"2.75\"", "scale=\"2,75\"", "Fz scale"},
                   {"scale=\"2.75\"", "scale=\"0.0\"", "Fz scale"},
                   {"scale=\"2.75\"", "scale=\"0.5\"", ""},
                   {"scale=\"2.75\"", "scale=\"-1\"", ""},  // a gauge that is wired the other way
                   {"scale=\"0.875\"", "scale=\"1e-307\"", "too large"},
                   {"max=\"70\"", "max=\"inf\"", "Fz max"},
                   {"max=\"70\"", "max=\"nan\"", "Fz max"},
                   {"max=\"70\"", "max=\"1000000000\"", "Fz max"},
                   {"max=\"70\"", "max=\"999999999\"", ""},
                   {"max=\"70\"", "max=\"0.5\"", ""},
                   {"max=\"70\"", "max=\"0\"", "Fz max"},
                   {"max=\"70\"", "max=\"-0.5\"", "Fz max"},
                   {"NumGages=\"6\"", "NumGages=\"7\"", "NumGages"},
                   {"NumGages=\"6\"", "NumGages=\"six\"", "NumGages"},
                   {"CalFileVersion=\"1.0\"", "CalFileVersion=\"1.2\"", "1.2"},
                   {"CalFileVersion=\"1.0\"", "CalFileVersion=\"1.1\"", ""},
                   {"ForceUnits=\"N\"", "ForceUnits=\"stone\"", "ForceUnits"},
                   {"TorqueUnits=\"N-mm\"", "TorqueUnits=\"N\"", "TorqueUnits"},
                   {"DistUnits=\"mm\"", "DistUnits=\"px\"", "DistUnits"},
                   {"DistUnits", "AngleUnits=\"grad\" DistUnits", "AngleUnits"},
                   {"-0.25  0.5", "-0,25  0.5", "Axis Fx"},
                   {"-0.25  0.5", "-0.25", "Axis Fx"},
                   {"-0.25  0.5", "-0.25 0.5 7", "Axis Fx"},
                   {"-0.25  0.5", "nan  0.5", "Axis Fx"}});
}

TEST_CASE("calibration refused: each part of the transform in its unit, and 0 where it is left out") {
  const std::string parts[2][3] = {{"Dx", "Dy", "Dz"}, {"Rx", "Ry", "Rz"}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t turned = 0; turned < 2; ++turned) {
      InventedCalibration invented;
      invented.distance_unit = "cm";
      invented.basic = "<BasicTransform " + parts[turned][i] + "=\"3\"/>";
      const auto basic = parse_ati_calibration(invented.text(), "C").basic;
      std::array<double, 3> moved{}, angles{};
      (turned == 0 ? moved : angles)[i] = turned == 0 ? 30.0 : 3.0;
      CHECK(basic.displacement_mm == moved);
      CHECK(basic.rotation_deg == angles);
      invented.basic = "<BasicTransform " + parts[turned][i] + "=\"3 mm\"/>";
      check_calibration(invented.text(), parts[turned][i]);
    }
  }
}

TEST_CASE("calibration refused: each part of the temperature compensation requires the others, once") {
  const std::string bias = R"(<BiasSlope values="1 2 3 4 5 6"/>)", gain = R"(<GainSlope values="1 2 3 4 5 6"/>)",
                    thermistor = R"(<Thermistor value="1"/>)";
  check_more(bias + gain + thermistor, "");
  for (const std::string& part : {bias, gain, thermistor}) check_more(part, " no ");
  check_more(bias + gain, "Thermistor");
  check_more(bias + thermistor, "GainSlope");
  check_more(gain + thermistor, "BiasSlope");
  check_more(bias + gain + thermistor + bias, "BiasSlope");
  check_more(bias + gain + thermistor + gain, "GainSlope");
  check_more(bias + gain + thermistor + thermistor, "Thermistor");
  check_more(R"(<BiasSlope values="1 2 3"/>)" + gain + thermistor, "BiasSlope");
  check_more(bias + "<GainSlope/>" + thermistor, "GainSlope");
  check_more(bias + gain + R"(<Thermistor value="x"/>)", "Thermistor");
}

TEST_CASE("calibration refused: elements that are there twice, and texts that are no calibration") {
  const std::string good = InventedCalibration().text(), basic = InventedCalibration().basic;
  const std::string sensor = good.substr(good.find("<FTSensor"));
  check_calibration(sensor + sensor, "FTSensor");
  check_exchanges({{"</Calibration>", "</Calibration><Calibration/>", "Calibration"}, {basic, basic + basic, "Basic"}});
  check_calibration("<FTSensor Serial=\"a\"/>", "Calibration");
  check_calibration("<a/>", "FTSensor");
  check_calibration(std::string(1'048'577, ' '), "1048577");
  for (const std::string& text : {std::string(), good.substr(0, good.size() / 2), std::string("<a></b>")})
    check_calibration(text, "XML");
}

TEST_CASE("calibration refused: a file that is absent, empty, no file or no XML") {
  const TemporaryFolder folder;
  const std::string path = folder.path("t.cal");
  const auto check_refused = [&](const std::string& file) {
    check_fault([&] { (void)read_ati_calibration(file); }, "TB-FORCE-CALIBRATION", {}, file);
  };
  check_refused(path);
  for (const char* text : {"", "x"}) {
    std::ofstream(path) << text;
    check_refused(path);
  }
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  check_refused(path);
  // Files of the kernel's that have no end or say no length; as root, one of them would be waited for.
  for (const char* kernels : {"/dev/zero", "/proc/kmsg", "/proc/self/mem"}) check_refused(kernels);
}
