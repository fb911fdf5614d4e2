// Calibration of an ATI transducer: parses `.cal` text into numbers. No I/O except in read_ati_calibration(). Not
// verified on hardware.
//
// XML: FTSensor (Serial, BodyStyle, NumGages = 6, CalFileVersion 1.0 or 1.1) > Calibration (PartNumber, CalDate,
// ForceUnits, TorqueUnits, DistUnits, AngleUnits default degrees) > six Axis (Name, values, max, scale default 1),
// BasicTransform (Dx, Dy, Dz, Rx, Ry, Rz, default 0), temperature compensation where fitted (BiasSlope values,
// GainSlope values, Thermistor value), six UserAxis (Name, values, max) in version 1.1.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "devices/force/options.h"

namespace tactbench::devices {

struct AtiAxis {
  std::array<double, 6> values{};  // of each gauge: file's unit times scale, per volt
  double scale = 1.0;
  double max = 0.0;  // rated range, file's unit
  bool operator==(const AtiAxis&) const = default;
};

struct AtiTemperature {
  std::array<double, 6> bias_slope{};
  std::array<double, 6> gain_slope{};
  double thermistor_v = 0.0;  // at calibration
  bool operator==(const AtiTemperature&) const = default;
};

struct AtiCalibration {
  std::string serial;
  std::string body_style;
  std::string part_number;  // "SI-25-0.25"
  std::string date;         // as written
  std::string version;
  std::string force_unit;
  std::string torque_unit;
  std::array<AtiAxis, 6> axes{};  // Fx, Fy, Fz, Tx, Ty, Tz
  AtiTransform basic;
  std::optional<AtiTemperature> temperature;
  // Version 1.1: the final rows, basic transform included; the file's own header says to use these.
  std::optional<std::array<AtiAxis, 6>> user_axes;
  bool operator==(const AtiCalibration&) const = default;
};

// `where` names the text in faults. Throws Fault TB-FORCE-CALIBRATION, naming the missing, duplicate or non-numeric
// element.
AtiCalibration parse_ati_calibration(std::string_view xml, const std::string& where);
// The same from a file of up to 1 MiB.
AtiCalibration read_ati_calibration(const std::string& path);

// Units and numbers as written in ATI's files; used by all readers of a calibration.

// The order of a wrench everywhere: rows of matrices, counts of records, ranges.
inline constexpr std::array<const char*, 6> kAxisNames{"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};

// Size of the named unit: in newtons ("N", "lbf", "kg", ...); in N*mm ("N-mm", "Nm", "lbf-in", "kg-cm", ...); in
// millimetres ("mm", "in", ...); in degrees ("degrees", "rad", ...). Empty for an unknown name.
[[nodiscard]] std::optional<double> newtons_in(std::string_view unit);
[[nodiscard]] std::optional<double> newton_millimetres_in(std::string_view unit);
[[nodiscard]] std::optional<double> millimetres_in(std::string_view unit);
[[nodiscard]] std::optional<double> degrees_in(std::string_view unit);
// The known names, for the text of a fault.
[[nodiscard]] std::string known_force_units();
[[nodiscard]] std::string known_torque_units();

// Parses the whole text, without surrounding blanks, as one finite number with a decimal point in any locale, or empty.
[[nodiscard]] std::optional<double> finite_number(std::string_view text);
// Parses exactly six such numbers separated by blanks and by `separator`; empty otherwise.
[[nodiscard]] std::optional<std::array<double, 6>> six_numbers(std::string_view text, char separator = ' ');

}  // namespace tactbench::devices
