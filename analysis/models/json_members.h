// Members of a stored model, with errors that name them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace tactbench::analysis {

// Throw std::invalid_argument when the member is missing, of another kind or not finite.
const nlohmann::ordered_json& json_member(const nlohmann::ordered_json& json, const std::string& name);
double json_number(const nlohmann::ordered_json& json, const std::string& name);
std::vector<double> json_numbers(const nlohmann::ordered_json& json, const std::string& name);

}  // namespace tactbench::analysis
