// Models as JSON, each complete in itself. The only source of this folder that needs another library
// than the standard one.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/models/model.h"

namespace tactbench::analysis {

// All members from which model_from_json makes the same model, bit for bit: "model" names the class, "x_low", "x_high",
// "y_low" and so on its range, "parameters", "weights", "a" and "b", or "x" and its outputs what it holds.
nlohmann::ordered_json model_json(const HysteresisModel& model);
// Throws std::invalid_argument that names the missing or wrong member.
std::unique_ptr<HysteresisModel> model_from_json(const nlohmann::ordered_json& json);

// Throw std::invalid_argument when the member is missing, of another kind or not finite.
const nlohmann::ordered_json& json_member(const nlohmann::ordered_json& json, const std::string& name);
double json_number(const nlohmann::ordered_json& json, const std::string& name);
std::vector<double> json_numbers(const nlohmann::ordered_json& json, const std::string& name);
bool json_flag(const nlohmann::ordered_json& json, const std::string& name);

}  // namespace tactbench::analysis
