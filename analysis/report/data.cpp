#include "analysis/report/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongList = 16;

bool is_long_list(const Json& json) {
  return json.is_array() && json.size() >= kLongList &&
         std::ranges::all_of(json, [](const Json& value) { return value.is_number_float() || value.is_null(); });
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
      text += Json(key).dump(-1, ' ', true, Json::error_handler_t::replace);
      text += ':';
      append_json(value, text);
    }
    text += '}';
  } else if (json.is_array()) {
    const bool rounded = is_long_list(json);
    text += '[';
    for (const Json& value : json) {
      between(first);
      const double number = rounded && value.is_number_float() ? value.get<double>() : std::nan("");
      if (std::isfinite(number))
        fmt::format_to(std::back_inserter(text), "{:.7g}", number);
      else
        append_json(value, text);
    }
    text += ']';
  } else {
    text += json.dump(-1, ' ', true, Json::error_handler_t::replace);
  }
}

}  // namespace

std::string json_text(const Json& json) {
  std::string text;
  append_json(json, text);
  return text;
}

}  // namespace tactbench::analysis
