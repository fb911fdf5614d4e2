#include "analysis/report/data/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kAroundDigits = 8;  // sign, point, "0.000" before a number or its exponent, comma

// As printf's %.<digits>g. Returns the end; there is room for it before `last`.
char* write_significant(char* to, char* last, double number, int digits) {
  if (!std::isfinite(number)) return std::copy_n("null", 4, to);
  return std::to_chars(to, last, number, std::chars_format::general, digits).ptr;
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
  char* const last = begin + text.size();
  char* to = begin;
  *to++ = '[';
  for (const double value : values) {
    if (to != begin + 1) *to++ = ',';
    to = write_significant(to, last, value, digits);
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
