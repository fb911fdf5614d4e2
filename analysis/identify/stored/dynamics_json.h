// Additional members of a dynamic model's document: "dynamics", and three members per taxel.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

nlohmann::ordered_json dynamics_json(const SensorDynamics& dynamics);
// The readers throw std::invalid_argument that names the member that is missing, of another kind or out of range.
SensorDynamics dynamics_from(const nlohmann::ordered_json& json);

void add_taxel_dynamics(const ModelTaxel& taxel, nlohmann::ordered_json& json);
void read_taxel_dynamics(const nlohmann::ordered_json& json, ModelTaxel& taxel);

}  // namespace tactbench::analysis
