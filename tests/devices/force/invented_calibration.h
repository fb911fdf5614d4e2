// A .cal text with invented numbers (no transducer has them), and the same numbers for the test's own computation.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string>

namespace tactbench::devices {

struct InventedCalibration {
  std::array<std::array<double, 6>, 6> rows{{{-0.25, 0.5, 1.25, -36.5, -1.5, 37.25},
                                             {1.75, 42.5, -0.75, -21.5, 0.25, -20.5},
                                             {23.5, -0.5, 22.25, 0.5, 24.125, -1.25},
                                             {-0.5, 0.25, 37.5, -1.75, -38.25, 1.5},
                                             {-43.5, 0.75, 22.5, 0.125, 21.25, -0.5},
                                             {0.875, 21.5, 0.5, 22.75, -0.25, 20.125}}};
  std::array<double, 6> scale{5.5, 5.5, 2.75, 0.875, 0.875, 0.8125};
  std::array<double, 6> max{50, 50, 70, 500, 500, 500};
  std::string force_unit = "N", torque_unit = "N-mm", distance_unit = "mm", version = "1.0", gauges = "6";
  std::string serial = "FT99901";
  std::string basic = R"(<BasicTransform Dx="0" Dy="0" Dz="6.096" Rx="0" Ry="0" Rz="0"/>)";
  std::string more;  // elements at the end of Calibration

  [[nodiscard]] std::string text() const {
    constexpr const char* kNames[] = {"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};
    std::string axes;
    for (std::size_t i = 0; i < 6; ++i) {
      axes += fmt::format("    <Axis Name=\"{}\" values=\" {} \" max=\"{}\" scale=\"{}\"/>\n", kNames[i],
                          fmt::join(rows[i], "  "), max[i], scale[i]);
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- invented numbers -->\n"
        "<FTSensor  Serial=\"{}\" BodyStyle=\"Nano17\" Family=\"DAQ\" NumGages=\"{}\" CalFileVersion=\"{}\">\n"
        "  <Calibration  PartNumber=\"SI-50-0.5\" CalDate=\"2/30/2020\" ForceUnits=\"{}\" TorqueUnits=\"{}\" "
        "DistUnits=\"{}\" OutputMode=\"Ground Referenced Differential\" OutputRange=\"20\">\n{}    {}\n{}\n"
        "  </Calibration>\n</FTSensor>\n",
        serial, gauges, version, force_unit, torque_unit, distance_unit, axes, basic, more);
  }
};

inline const char* const kInventedTemperature =
    R"(<BiasSlope values="0.01 -0.02 0.03 0 0.05 -0.06"/><GainSlope values="0.1 0 -0.1 0.2 0.05 -0.3"/>)"
    R"(<Thermistor value="1.25"/>)";

}  // namespace tactbench::devices
