// A .cal file attribute by attribute: each that has to be there, each number for itself, every word of a complaint.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "devices/force/ati_calibration.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/invented_calibration.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

// The complaint behind "reading the calibration C: ".
std::string refusal_of(const std::string& text) {
  const auto fault = fault_of([&] { (void)parse_ati_calibration(text, "C"); });
  if (!fault) return "";
  CHECK((fault->id() == "TB-FORCE-CALIBRATION" && fault->device() == "force sensor"));
  const std::string what = fault->what(), front = "reading the calibration C: ";
  REQUIRE(what.starts_with(front));
  return what.substr(front.size());
}

std::string exchanged(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

InventedCalibration with_more(const std::string& more) {
  InventedCalibration invented;
  invented.more = more;
  return invented;
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

TEST_CASE("calibration told: each attribute that has to be there") {
  const std::string good = InventedCalibration().text();
  const auto without = [&](const std::string& name, const std::string& value) {
    return refusal_of(exchanged(good, name + "=\"" + value + "\"", ""));
  };
  CHECK(without("Serial", "FT99901") == "FTSensor has no attribute Serial");
  CHECK(without("BodyStyle", "Nano17") == "FTSensor has no attribute BodyStyle");
  CHECK(without("NumGages", "6") == "FTSensor has no attribute NumGages");
  CHECK(without("CalFileVersion", "1.0") == "FTSensor has no attribute CalFileVersion");
  CHECK(without("PartNumber", "SI-50-0.5") == "Calibration has no attribute PartNumber");
  CHECK(without("CalDate", "2/30/2020") == "Calibration has no attribute CalDate");
  CHECK(without("ForceUnits", "N") == "Calibration has no attribute ForceUnits");
  CHECK(without("TorqueUnits", "N-mm") == "Calibration has no attribute TorqueUnits");
  CHECK(without("DistUnits", "mm") == "Calibration has no attribute DistUnits");
  CHECK(without("Name", "Fx") == "Axis has no attribute Name");
  CHECK(without("max", "70") == "Axis has no attribute max");
  CHECK(refusal_of(exchanged(good, "values=", "vals=")) == "Axis has no attribute values");
  CHECK(without("Family", "DAQ").empty());
}

TEST_CASE("calibration told: each axis has to be there, once, by its name") {
  const std::string good = InventedCalibration().text();
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string named = "Axis Name=\"" + kNames[i] + "\"";
    CHECK(refusal_of(exchanged(good, named, "Extra Name=\"x\"")) == "Axis " + kNames[i] + " is missing");
    CHECK(refusal_of(exchanged(good, named, "Axis Name=\"f\"")) == "Axis is named 'f', not one of Fx Fy Fz Tx Ty Tz");
    const std::size_t other = (i + 1) % 6;
    CHECK(refusal_of(exchanged(good, named, "Axis Name=\"" + kNames[other] + "\"")) ==
          "Axis " + kNames[other] + " is present twice");
    CHECK(refusal_of(with_more(user_axes_without(i)).text()) == "UserAxis " + kNames[i] + " is missing");
  }
  CHECK(refusal_of(with_more(user_axes_without(6)).text()).empty());
}

TEST_CASE("calibration told: each number is a number, and is named") {
  const std::string good = InventedCalibration().text();
  CHECK(refusal_of(exchanged(good, "scale=\"2.75\"", "scale=\"2,75\"")) == "Axis Fz scale: '2,75' is not a number");
  CHECK(refusal_of(exchanged(good, "scale=\"2.75\"", "scale=\"0.0\"")) == "Axis Fz scale is 0");
  CHECK(refusal_of(exchanged(good, "scale=\"2.75\"", "scale=\"0.5\"")).empty());
  CHECK(refusal_of(exchanged(good, "scale=\"2.75\"", "scale=\"-1\"")).empty());  // a gauge that is wired the other way
  CHECK(refusal_of(exchanged(good, "max=\"70\"", "max=\"inf\"")) == "Axis Fz max: 'inf' is not a number");
  CHECK(refusal_of(exchanged(good, "max=\"70\"", "max=\"1e9\"")) == "Axis Fz max is 1e+09, not a valid range");
  CHECK(refusal_of(exchanged(good, "max=\"70\"", "max=\"-0.5\"")) == "Axis Fz max is -0.5, not a valid range");
  CHECK(refusal_of(exchanged(good, "NumGages=\"6\"", "NumGages=\"7\"")) ==
        "NumGages is 7; transducers of 6 gauges are known");
  CHECK(refusal_of(exchanged(good, "NumGages=\"6\"", "NumGages=\"six\"")) ==
        "FTSensor NumGages: 'six' is not a number");
  CHECK(refusal_of(exchanged(good, "CalFileVersion=\"1.0\"", "CalFileVersion=\"1.2\"")) ==
        "CalFileVersion is 1.2; versions 1.0 and 1.1 are known");
  for (const char* version : {"1.0", "1.1"})
    CHECK(refusal_of(exchanged(good, "CalFileVersion=\"1.0\"", std::string("CalFileVersion=\"") + version + "\""))
              .empty());
  CHECK(refusal_of(with_more(R"(<BiasSlope values="1 2 3"/><GainSlope values="1 2 3 4 5 6"/><Thermistor value="1"/>)")
                       .text()) == "BiasSlope values: '1 2 3' are not six numbers");
  CHECK(refusal_of(with_more(R"(<BiasSlope values="1 2 3 4 5 6"/><GainSlope/><Thermistor value="1"/>)").text()) ==
        "GainSlope has no attribute values");
  CHECK(refusal_of(
            with_more(R"(<BiasSlope values="1 2 3 4 5 6"/><GainSlope values="1 2 3 4 5 6"/><Thermistor value="x"/>)")
                .text()) == "Thermistor value: 'x' is not a number");
}

TEST_CASE("calibration told: each part of the transform in its unit, and 0 where it is left out") {
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
      CHECK(refusal_of(invented.text()) == "BasicTransform " + parts[turned][i] + ": '3 mm' is not a number");
    }
  }
  InventedCalibration unknown;
  unknown.distance_unit = "px";
  CHECK(refusal_of(unknown.text()) == "DistUnits 'px' is unknown; known: mm, cm, m, in, ft");
  CHECK(refusal_of(exchanged(InventedCalibration().text(), "DistUnits", "AngleUnits=\"grad\" DistUnits")) ==
        "AngleUnits 'grad' is unknown; known: degrees, radians");
}

TEST_CASE("calibration told: elements that are there twice, and texts that are no calibration") {
  const std::string good = InventedCalibration().text();
  const std::string sensor = good.substr(good.find("<FTSensor"));
  CHECK(refusal_of(sensor + sensor) == "FTSensor is present more than once");
  CHECK(refusal_of(exchanged(good, "</Calibration>", "</Calibration><Calibration/>")) ==
        "Calibration is present more than once");
  const std::string bias = R"(<BiasSlope values="1 2 3 4 5 6"/>)", gain = R"(<GainSlope values="1 2 3 4 5 6"/>)",
                    thermistor = R"(<Thermistor value="1"/>)";
  CHECK(refusal_of(with_more(bias + gain + thermistor + gain).text()) == "GainSlope is present more than once");
  CHECK(refusal_of(with_more(bias + gain + thermistor + thermistor).text()) == "Thermistor is present more than once");
  CHECK(refusal_of(with_more(gain + thermistor).text()) == "Calibration holds no BiasSlope");
  CHECK(refusal_of("<a/>") == "it holds no FTSensor");
  CHECK(refusal_of(std::string(1'048'577, ' ')) == "it has 1048577 bytes, at most 1048576");
  CHECK_THAT(refusal_of("<a></b>"), Catch::StartsWith("it is not XML: ") && Catch::EndsWith(" at byte 5"));
  InventedCalibration huge;
  huge.scale[4] = 1e-307;
  CHECK(refusal_of(huge.text()) == "its numbers are too large for a matrix");
}

TEST_CASE("calibration told: a file of one byte is read, one of none is empty") {
  const TemporaryFolder folder;
  const std::string path = folder.path("t.cal");
  const auto said = [&] {
    const auto fault = fault_of([&] { (void)read_ati_calibration(path); });
    REQUIRE(fault);
    return std::string(fault->what());
  };
  const std::string front = "reading the calibration " + path + ": ";
  CHECK(said() == front + "it cannot be opened");
  std::ofstream(path) << "";
  CHECK(said() == front + "it is empty");
  std::ofstream(path) << "x";
  CHECK_THAT(said(), Catch::StartsWith(front + "it is not XML"));
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  CHECK(said() == front + "it is not a regular file");
}
