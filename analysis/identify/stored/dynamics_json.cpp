#include "analysis/identify/stored/dynamics_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "analysis/json_fields.h"
#include "analysis/models/model_json.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

double within(const Json& json, const std::string& name, double low, double high) {
  const double value = json_number(json, name);
  if (value < low || value > high)
    throw std::invalid_argument("\"" + name + "\" is not within " + std::to_string(low) + " and " +
                                std::to_string(high));
  return value;
}

std::array<double, kCreepElements> elements_from(const Json& json, const std::string& name) {
  const std::vector<double> list = json_numbers(json, name);
  if (list.size() != kCreepElements || std::ranges::any_of(list, [](double value) { return value < 0.0; }))
    throw std::invalid_argument("\"" + name + "\" is not a list of three numbers from 0 on");
  std::array<double, kCreepElements> elements;
  std::ranges::copy(list, elements.begin());
  return elements;
}

Json source_json(const SensorDynamics::Source& source) { return {JSON_FIELDS(source, run, content_sha256)}; }

SensorDynamics::Source source_from(const Json& json, const std::string& name) {
  const Json& source = json_member(json, name);
  const double run = json_number(source, "run");
  const Json& hash = json_member(source, "content_sha256");
  if (run != std::floor(run) || std::abs(run) > 1e15 || !hash.is_string())
    throw std::invalid_argument("\"" + name + "\" names no run");
  return {static_cast<std::int64_t>(run), hash.get<std::string>()};
}

}  // namespace

nlohmann::ordered_json dynamics_json(const SensorDynamics& dynamics) {
  const Dynamics& d = dynamics.shared;
  return {JSON_FIELDS(d, creep_s, creep_share, creep_half, lag_s, lag_share),
          {"residual_shape", dynamics.residual_shape},
          {"rate", source_json(dynamics.rate)},
          {"creep", source_json(dynamics.creep)}};
}

SensorDynamics dynamics_from(const nlohmann::ordered_json& json) {
  SensorDynamics dynamics;
  Dynamics& d = dynamics.shared;
  d.creep_s = elements_from(json, "creep_s");
  if (std::ranges::find(d.creep_s, 0.0) != d.creep_s.end()) throw std::invalid_argument("a \"creep_s\" is 0");
  d.creep_share = elements_from(json, "creep_share");
  d.creep_half = within(json, "creep_half", 1e-9, 1e9);
  d.lag_s = within(json, "lag_s", 1e-9, 1e9);
  d.lag_share = within(json, "lag_share", 0.0, 0.9);
  dynamics.residual_shape = json_numbers(json, "residual_shape");
  if (std::ranges::any_of(dynamics.residual_shape, [](double value) { return value < 0.0; }))
    throw std::invalid_argument("\"residual_shape\" has a negative number");
  dynamics.rate = source_from(json, "rate");
  dynamics.creep = source_from(json, "creep");
  return dynamics;
}

void add_taxel_dynamics(const ModelTaxel& taxel, nlohmann::ordered_json& json) {
  json["creep_scale"] = taxel.creep_scale;
  json["lag_share"] = taxel.lag_share;
  json["residual_psi"] = taxel.residual_psi;
}

void read_taxel_dynamics(const nlohmann::ordered_json& json, ModelTaxel& taxel) {
  taxel.creep_scale = within(json, "creep_scale", 0.0, 10.0);
  taxel.lag_share = within(json, "lag_share", 0.0, 0.9);
  taxel.residual_psi = within(json, "residual_psi", 0.0, 1e9);
}

}  // namespace tactbench::analysis
