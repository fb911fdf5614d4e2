#include "devices/force/ati_units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

namespace tactbench::devices {
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
