#include "analysis/report/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLeastPower = -4;
constexpr std::array<double, 14> kPowers = {1e-4, 1e-3, 1e-2, 1e-1, 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
double power_of_ten(int power) { return kPowers[static_cast<std::size_t>(power - kLeastPower)]; }

constexpr std::size_t kAroundDigits = 8;  // sign, "0.000" before a number or its exponent, comma

// What {:.<digits>g} writes, in a fifth of its time: a report has 100 000 of them. 1 <= digits <= 9. Returns the end.
char* write_significant(char* to, double number, int digits) {
  if (!std::isfinite(number)) return fmt::format_to(to, "null");
  const double size = std::abs(number);
  if (size < power_of_ten(kLeastPower) || size >= power_of_ten(digits - 1))
    return fmt::format_to(to, "{:.{}g}", number, digits);
  int power = kLeastPower;  // of the first digit
  while (size >= power_of_ten(power + 1)) ++power;
  int decimals = digits - 1 - power;
  auto mantissa = static_cast<std::uint64_t>(std::llrint(size * power_of_ten(digits - 1) / power_of_ten(power)));
  while (decimals > 0 && mantissa % 10 == 0) {
    mantissa /= 10;
    --decimals;
  }
  std::array<char, 24> room{};
  char* const end = room.data() + room.size();
  char* first = end;
  const auto add_digit = [&] {
    *--first = static_cast<char>('0' + mantissa % 10);
    mantissa /= 10;
  };
  if (decimals > 0) {
    for (; decimals > 0; --decimals) add_digit();
    *--first = '.';
  }
  do add_digit();
  while (mantissa > 0);
  if (number < 0.0) *--first = '-';
  return std::copy(first, end, to);
}

void append_string(std::string& text, const std::string& value) {
  const auto plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
  if (std::ranges::all_of(value, plain)) {
    text += '"';
    text += value;
    text += '"';
  } else {
    text += Json(value).dump(-1, ' ', true, Json::error_handler_t::replace);
  }
}

void append_json(const Json& json, std::string& text) {
  const auto between = [&](bool& first) {
    if (!first) text += ',';
    first = false;
  };
  bool first = true;
  if (json.is_object()) {
    text += '{';
    for (const auto& [key, value] : json.items()) {
      between(first);
      append_string(text, key);
      text += ':';
      append_json(value, text);
    }
    text += '}';
  } else if (json.is_array()) {
    text += '[';
    for (const Json& value : json) {
      between(first);
      append_json(value, text);
    }
    text += ']';
  } else if (json.is_binary()) {
    const auto& finished = json.get_binary();
    text.append(reinterpret_cast<const char*>(finished.data()), finished.size());
  } else if (json.is_string()) {
    append_string(text, json.get_ref<const std::string&>());
  } else if (json.is_number_float()) {
    const auto number = json.get<double>();
    if (std::isfinite(number))
      fmt::format_to(std::back_inserter(text), "{}", number);  // as many digits as tell it from its neighbours
    else
      text += "null";
  } else if (json.is_number_integer()) {
    const auto digits = json.is_number_unsigned() ? fmt::format_int(json.get<std::uint64_t>())
                                                  : fmt::format_int(json.get<std::int64_t>());
    text.append(digits.data(), digits.size());
  } else {
    text += json.is_boolean() ? (json.get<bool>() ? "true" : "false") : "null";
  }
}

}  // namespace

Json number_list(std::span<const double> values, int digits) {
  std::vector<std::uint8_t> text((static_cast<std::size_t>(digits) + kAroundDigits) * values.size() + 2);
  char* const begin = reinterpret_cast<char*>(text.data());
  char* to = begin;
  *to++ = '[';
  for (const double value : values) {
    if (to != begin + 1) *to++ = ',';
    to = write_significant(to, value, digits);
  }
  *to++ = ']';
  text.resize(static_cast<std::size_t>(to - begin));
  return Json::binary(std::move(text));
}

std::string json_text(const Json& json) {
  std::string text;
  append_json(json, text);
  return text;
}

}  // namespace tactbench::analysis
