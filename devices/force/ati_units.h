// Units and numbers as ATI's files write them. Used by every reader of a calibration.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace tactbench::devices {

// The order of a wrench everywhere: rows of matrices, counts of records, ranges.
inline constexpr std::array<const char*, 6> kAxisNames{"Fx", "Fy", "Fz", "Tx", "Ty", "Tz"};

// Newtons in one unit named so ("N", "lbf", "kg", ...); N*mm in one ("N-mm", "Nm", "lbf-in", "kg-cm", ...);
// millimetres in one ("mm", "in", ...); degrees in one ("degrees", "rad", ...). Empty for an unknown name.
[[nodiscard]] std::optional<double> newtons_in(std::string_view unit);
[[nodiscard]] std::optional<double> newton_millimetres_in(std::string_view unit);
[[nodiscard]] std::optional<double> millimetres_in(std::string_view unit);
[[nodiscard]] std::optional<double> degrees_in(std::string_view unit);
// The known names, for a fault's text.
[[nodiscard]] std::string known_force_units();
[[nodiscard]] std::string known_torque_units();

// The whole text, without blanks around it, as one finite number with a decimal point in any locale; empty otherwise.
[[nodiscard]] std::optional<double> finite_number(std::string_view text);
// Exactly six such numbers separated by blanks and by `separator`; empty otherwise.
[[nodiscard]] std::optional<std::array<double, 6>> six_numbers(std::string_view text, char separator = ' ');

}  // namespace tactbench::devices
