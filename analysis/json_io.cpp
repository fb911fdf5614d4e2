#include "analysis/json_io.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tactbench::analysis {

using nlohmann::ordered_json;

namespace {

bool is_within_bounds(const std::string& text) {
  if (text.size() > kMaxJsonBytes) return false;
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '[' || c == '{')) {
      if (++depth > kMaxJsonDepth) return false;
    } else if (!quoted && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return true;
}

template <class Json>
Json parsed(const std::string& text) {
  if (is_within_bounds(text)) return Json::parse(text);
  throw Json::other_error::create(
      501, fmt::format("longer than {} bytes, or nested deeper than {}", kMaxJsonBytes, kMaxJsonDepth), nullptr);
}

template <class Json>
Json parsed_if_it_is(const std::string& text) {
  return is_within_bounds(text) ? Json::parse(text, nullptr, false) : Json(Json::value_t::discarded);
}

}  // namespace

nlohmann::json parse_json(const std::string& text) { return parsed<nlohmann::json>(text); }
ordered_json parse_ordered_json(const std::string& text) { return parsed<ordered_json>(text); }
nlohmann::json try_json(const std::string& text) { return parsed_if_it_is<nlohmann::json>(text); }
ordered_json try_ordered_json(const std::string& text) { return parsed_if_it_is<ordered_json>(text); }
ordered_json ordered_json_or_null(const std::string& text) {
  ordered_json parsed = try_ordered_json(text);
  return parsed.is_discarded() ? ordered_json() : parsed;
}

std::string json_line(const nlohmann::json& value) { return value.dump(); }
std::string json_line(const ordered_json& value) { return value.dump(); }
std::string printable_json(const nlohmann::json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}
std::string printable_json(const ordered_json& value, int indent) {
  return value.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace tactbench::analysis
