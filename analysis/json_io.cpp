#include "analysis/json_io.h"

#include <nlohmann/json.hpp>

namespace tactbench::analysis {

using nlohmann::json;
using nlohmann::ordered_json;

json parse_json(const std::string& text) { return json::parse(text); }
ordered_json parse_ordered_json(const std::string& text) { return ordered_json::parse(text); }
json try_json(const std::string& text) { return json::parse(text, nullptr, false); }
ordered_json try_ordered_json(const std::string& text) { return ordered_json::parse(text, nullptr, false); }
ordered_json ordered_json_or_null(const std::string& text) {
  ordered_json parsed = try_ordered_json(text);
  return parsed.is_discarded() ? ordered_json() : parsed;
}

std::string json_line(const json& json) { return json.dump(); }
std::string json_line(const ordered_json& json) { return json.dump(); }
std::string printable_json(const json& json, int indent) {
  return json.dump(indent, ' ', false, json::error_handler_t::replace);
}
std::string printable_json(const ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace tactbench::analysis
