// JSON as the report carries it: one line, ASCII; what is not finite becomes null.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tactbench::analysis {

inline std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tactbench::analysis
