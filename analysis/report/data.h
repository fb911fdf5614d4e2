// JSON as the report carries it: one line, ASCII; what is not finite becomes null.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tactbench::analysis {

// Lists of sixteen numbers or more, which are curves and maps, carry seven significant digits, finer than any converter
// step; every other number all that it has.
std::string json_text(const nlohmann::ordered_json& json);

}  // namespace tactbench::analysis
