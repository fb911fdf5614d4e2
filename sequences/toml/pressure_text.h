// Pressures as people type them: a number with its unit, "20kPa", "0.2 bar", "3 psi". Accepted for each key with a
// pressure in recipes, bench files and on the command line; a bare number is in the unit of its key.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tactbench::sequences {

// One of `unit` in psi: "psi", "kPa", "bar". Any other word counts as psi.
double psi_per_unit(std::string_view unit);
// In psi; none when `text` is not a number followed by psi, kPa or bar (in any case, blanks allowed).
std::optional<double> typed_pressure_psi(std::string_view text);
// `value` as a bare number in `unit`, if `value` is a pressure with a unit and `unit` is a unit of pressure; else
// unchanged.
std::string as_number_in(std::string_view unit, const std::string& value);

}  // namespace tactbench::sequences
