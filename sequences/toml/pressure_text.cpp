#include "sequences/toml/pressure_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "devices/units.h"

namespace tactbench::sequences {

namespace {

constexpr std::array kPressureUnits = {"psi", "kPa", "bar"};

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t from = text.find_first_not_of(kBlanks);
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(kBlanks) - from + 1);
}

bool same_word(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

}  // namespace

double psi_per_unit(std::string_view unit) {
  if (unit == "kPa") return 1.0 / devices::kKilopascalsPerPsi;
  if (unit == "bar") return devices::kPsiPerBar;
  return 1.0;
}

std::optional<double> typed_pressure_psi(std::string_view text) {
  text = without_blanks(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return {};
  const std::string_view word = without_blanks(text.substr(static_cast<std::size_t>(end - text.data())));
  for (const char* unit : kPressureUnits)
    if (same_word(word, unit)) return value * psi_per_unit(unit);
  return {};
}

std::string as_number_in(std::string_view unit, const std::string& value) {
  if (std::ranges::find(kPressureUnits, unit) == kPressureUnits.end()) return value;
  const std::optional<double> psi = typed_pressure_psi(value);
  return psi ? fmt::format("{:.12g}", *psi / psi_per_unit(unit)) : value;
}

}  // namespace tactbench::sequences
