// Units and numbers as written in ATI's files; used by all readers of a calibration.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace tactbench::devices {

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
