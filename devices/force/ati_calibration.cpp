#include "devices/force/ati_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <pugixml.hpp>
#include <span>

#include "devices/device.h"
#include "devices/force/ati_matrix.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kLargestFile = std::size_t{1} << 20U;
constexpr double kLargestRatedLoad = 1e9;

// Reads one file; every fault names the file and the element.
class CalibrationReader {
 public:
  explicit CalibrationReader(const std::string& where) : where_(where) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Fault("TB-FORCE-CALIBRATION", "force sensor", fmt::format("reading the calibration {}: {}", where_, what),
                "Take the .cal file that came with the transducer of this serial number, unchanged.");
  }

  [[nodiscard]] std::string text(const pugi::xml_node& node, const char* name) const {
    const auto attribute = node.attribute(name);
    if (!attribute || *attribute.value() == '\0') fail(fmt::format("{} has no attribute {}", node.name(), name));
    return attribute.value();
  }

  [[nodiscard]] double number(const pugi::xml_node& node, const char* name, const char* otherwise = "") const {
    const std::string written = node.attribute(name) || *otherwise == '\0' ? text(node, name) : otherwise;
    const auto value = finite_number(written);
    if (!value) fail(fmt::format("{} {}: '{}' is not a number", title(node), name, written));
    return *value;
  }

  [[nodiscard]] std::array<double, 6> six(const pugi::xml_node& node) const {
    const std::string written = text(node, "values");
    const auto values = six_numbers(written);
    if (!values) fail(fmt::format("{} values: '{}' are not six numbers", title(node), written));
    return *values;
  }

  // Exactly one child of that name, or none where it may be absent.
  [[nodiscard]] pugi::xml_node only(const pugi::xml_node& parent, const char* name, bool required) const {
    const auto node = parent.child(name);
    if (!node && required) fail(fmt::format("{} holds no {}", *parent.name() == '\0' ? "it" : parent.name(), name));
    if (node && node.next_sibling(name)) fail(fmt::format("{} is present more than once", name));
    return node;
  }

  [[nodiscard]] std::array<AtiAxis, 6> axes(const pugi::xml_node& parent, const char* element) const {
    std::array<AtiAxis, 6> axes{};
    std::array<bool, 6> seen{};
    for (const auto& node : parent.children(element)) {
      const std::string name = text(node, "Name");
      std::size_t row = 0;
      while (row < 6 && name != kAxisNames[row]) ++row;
      if (row == 6) fail(fmt::format("{} is named '{}', not one of Fx Fy Fz Tx Ty Tz", element, name));
      if (seen[row]) fail(fmt::format("{} {} is present twice", element, name));
      seen[row] = true;
      axes[row] = {six(node), number(node, "scale", "1"), number(node, "max")};
      if (axes[row].scale == 0.0) fail(fmt::format("{} scale is 0", title(node)));
      if (!(axes[row].max > 0.0 && axes[row].max < kLargestRatedLoad)) {
        fail(fmt::format("{} max is {:g}, not a valid range", title(node), axes[row].max));
      }
    }
    for (std::size_t row = 0; row < 6; ++row) {
      if (!seen[row]) fail(fmt::format("{} {} is missing", element, kAxisNames[row]));
    }
    return axes;
  }

 private:
  static std::string title(const pugi::xml_node& node) {
    const auto name = node.attribute("Name");
    return name ? fmt::format("{} {}", node.name(), name.value()) : node.name();
  }
  const std::string& where_;
};

AtiTransform basic_transform(const CalibrationReader& reader, const pugi::xml_node& calibration) {
  AtiTransform transform;
  const auto node = reader.only(calibration, "BasicTransform", false);
  if (!node) return transform;
  const std::string distance = reader.text(calibration, "DistUnits");
  const auto millimetres = millimetres_in(distance);
  if (!millimetres) reader.fail(fmt::format("DistUnits '{}' is unknown; known: mm, cm, m, in, ft", distance));
  const std::string angle = calibration.attribute("AngleUnits").as_string("degrees");
  const auto degrees = degrees_in(angle);
  if (!degrees) reader.fail(fmt::format("AngleUnits '{}' is unknown; known: degrees, radians", angle));
  constexpr const char* kNames[2][3] = {{"Dx", "Dy", "Dz"}, {"Rx", "Ry", "Rz"}};
  for (std::size_t i = 0; i < 3; ++i) {
    transform.displacement_mm[i] = *millimetres * reader.number(node, kNames[0][i], "0");
    transform.rotation_deg[i] = *degrees * reader.number(node, kNames[1][i], "0");
  }
  return transform;
}

std::optional<AtiTemperature> temperature(const CalibrationReader& reader, const pugi::xml_node& calibration) {
  if (!calibration.child("BiasSlope") && !calibration.child("GainSlope") && !calibration.child("Thermistor")) {
    return std::nullopt;
  }
  return AtiTemperature{reader.six(reader.only(calibration, "BiasSlope", true)),
                        reader.six(reader.only(calibration, "GainSlope", true)),
                        reader.number(reader.only(calibration, "Thermistor", true), "value")};
}

}  // namespace

AtiCalibration parse_ati_calibration(std::string_view xml, const std::string& where) {
  const CalibrationReader reader(where);
  if (xml.size() > kLargestFile) reader.fail(fmt::format("it has {} bytes, at most {}", xml.size(), kLargestFile));
  pugi::xml_document document;
  const auto parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) reader.fail(fmt::format("it is not XML: {} at byte {}", parsed.description(), parsed.offset));
  const auto sensor = reader.only(document, "FTSensor", true);
  const auto node = reader.only(sensor, "Calibration", true);

  AtiCalibration calibration;
  calibration.serial = reader.text(sensor, "Serial");
  calibration.body_style = reader.text(sensor, "BodyStyle");
  calibration.version = reader.text(sensor, "CalFileVersion");
  if (calibration.version != "1.0" && calibration.version != "1.1") {
    reader.fail(fmt::format("CalFileVersion is {}; versions 1.0 and 1.1 are known", calibration.version));
  }
  if (const double gauges = reader.number(sensor, "NumGages"); gauges != 6.0) {
    reader.fail(fmt::format("NumGages is {:g}; transducers of 6 gauges are known", gauges));
  }
  calibration.part_number = reader.text(node, "PartNumber");
  calibration.date = reader.text(node, "CalDate");
  calibration.force_unit = reader.text(node, "ForceUnits");
  if (!newtons_in(calibration.force_unit)) {
    reader.fail(fmt::format("ForceUnits '{}' is unknown; known: {}", calibration.force_unit, known_force_units()));
  }
  calibration.torque_unit = reader.text(node, "TorqueUnits");
  if (!newton_millimetres_in(calibration.torque_unit)) {
    reader.fail(fmt::format("TorqueUnits '{}' is unknown; known: {}", calibration.torque_unit, known_torque_units()));
  }
  calibration.axes = reader.axes(node, "Axis");
  calibration.basic = basic_transform(reader, node);
  calibration.temperature = temperature(reader, node);
  if (node.child("UserAxis")) calibration.user_axes = reader.axes(node, "UserAxis");
  if (!working_matrix(calibration).allFinite()) reader.fail("its numbers are too large for a matrix");
  return calibration;
}

AtiCalibration read_ati_calibration(const std::string& path) {
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown)) {
    CalibrationReader(path).fail("it is not a regular file");
  }
  // Files of /proc and /sys also have size 0; reading some of them blocks forever.
  if (std::filesystem::file_size(path, unknown) == 0) CalibrationReader(path).fail("it is empty");
  std::ifstream file(path, std::ios::binary);
  if (!file) CalibrationReader(path).fail("it cannot be opened");
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) CalibrationReader(path).fail("it cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_ati_calibration(text, path);
}

namespace {

struct Unit {
  const char* name;
  double factor;
};

// NIST SP 811: 1 in = 25.4 mm, 1 lb = 0.45359237 kg, g = 9.80665 m/s^2, all exact.
constexpr double kInch = 25.4;
constexpr double kKilogram = 9.80665;
constexpr double kPound = 0.45359237 * kKilogram;

constexpr Unit kForces[] = {{"N", 1.0},        {"kN", 1000.0},          {"lbf", kPound},
                            {"lb", kPound},    {"klbf", 1000 * kPound}, {"klb", 1000 * kPound},
                            {"kg", kKilogram}, {"kgf", kKilogram},      {"g", kKilogram / 1000}};
constexpr Unit kTorques[] = {{"N-mm", 1.0},
                             {"Nmm", 1.0},
                             {"N-m", 1e3},
                             {"Nm", 1e3},
                             {"kN-m", 1e6},
                             {"kNm", 1e6},
                             {"lbf-in", kPound* kInch},
                             {"lb-in", kPound* kInch},
                             {"in-lbf", kPound* kInch},
                             {"in-lb", kPound* kInch},
                             {"lbf-ft", kPound * 12 * kInch},
                             {"lb-ft", kPound * 12 * kInch},
                             {"ft-lbf", kPound * 12 * kInch},
                             {"ft-lb", kPound * 12 * kInch},
                             {"kg-cm", kKilogram * 10},
                             {"kgcm", kKilogram * 10}};
constexpr Unit kDistances[] = {{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}, {"in", kInch}, {"ft", 12 * kInch}};
constexpr double kRadian = 180.0 / std::numbers::pi;
constexpr Unit kAngles[] = {{"degrees", 1.0},     {"degree", 1.0},     {"deg", 1.0},
                            {"radians", kRadian}, {"radian", kRadian}, {"rad", kRadian}};

std::optional<double> find(std::span<const Unit> units, std::string_view name) {
  for (const Unit& unit : units) {
    if (name == unit.name) return unit.factor;
  }
  return std::nullopt;
}

std::string names(std::span<const Unit> units) {
  std::string list;
  for (const Unit& unit : units) list += (list.empty() ? "" : ", ") + std::string(unit.name);
  return list;
}

constexpr std::string_view kBlanks = " \t\r\n";

}  // namespace

std::optional<double> newtons_in(std::string_view unit) { return find(kForces, unit); }
std::optional<double> newton_millimetres_in(std::string_view unit) { return find(kTorques, unit); }
std::optional<double> millimetres_in(std::string_view unit) { return find(kDistances, unit); }
std::optional<double> degrees_in(std::string_view unit) { return find(kAngles, unit); }
std::string known_force_units() { return names(kForces); }
std::string known_torque_units() { return names(kTorques); }

std::optional<double> finite_number(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return std::nullopt;
  text = text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::array<double, 6>> six_numbers(std::string_view text, char separator) {
  std::array<double, 6> numbers{};
  const std::string between = std::string(kBlanks) + separator;
  std::size_t at = 0;
  for (double& number : numbers) {
    const auto begin = text.find_first_not_of(between, at);
    if (begin == std::string_view::npos) return std::nullopt;
    at = std::min(text.find_first_of(between, begin), text.size());
    const auto value = finite_number(text.substr(begin, at - begin));
    if (!value) return std::nullopt;
    number = *value;
  }
  if (text.find_first_not_of(between, at) != std::string_view::npos) return std::nullopt;
  return numbers;
}

}  // namespace tactbench::devices
