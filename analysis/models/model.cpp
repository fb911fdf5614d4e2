#include "analysis/models/model.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/gpi.h"
#include "analysis/models/json_members.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {

bool ModelParameter::at_bound() const {
  constexpr double kNear = 1e-9;
  const double distance = std::isfinite(high - low) ? high - low : 1.0;
  return value - low <= kNear * distance || high - value <= kNear * distance;
}

const nlohmann::ordered_json& json_member(const nlohmann::ordered_json& json, const std::string& name) {
  if (!json.is_object() || !json.contains(name)) throw std::invalid_argument("model: \"" + name + "\" is missing");
  return json.at(name);
}

double json_number(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& value = json_member(json, name);
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw std::invalid_argument("model: \"" + name + "\" is not a number");
  return value.get<double>();
}

std::vector<double> json_numbers(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& list = json_member(json, name);
  const auto number = [](const auto& value) {
    return value.is_number() && std::isfinite(value.template get<double>());
  };
  if (!list.is_array() || !std::ranges::all_of(list, number))
    throw std::invalid_argument("model: \"" + name + "\" is not a list of numbers");
  return list.get<std::vector<double>>();
}

std::unique_ptr<HysteresisModel> model_from_json(const nlohmann::ordered_json& json) {
  const nlohmann::ordered_json& model = json_member(json, "model");
  if (!model.is_string()) throw std::invalid_argument("model: \"model\" is not a name");
  const auto name = model.get<std::string>();
  if (name == "elam") return elam_from_json(json);
  if (name == "gpi") return GpiModel::from_json(json);
  if (name == "mpi") return MpiModel::from_json(json);
  if (name == "poly") return PolyModel::from_json(json);
  if (name == "preisach") return PreisachModel::from_json(json);
  if (name == "monotone") return MonotoneModel::from_json(json);
  if (name == "linearised") return LinearisedModel::from_json(json);
  throw std::invalid_argument("model: \"model\" is \"" + name + "\", which this program does not know");
}

std::vector<double> predict(const HysteresisModel& model, std::span<const double> inputs) {
  const auto state = model.state();
  std::vector<double> outputs;
  outputs.reserve(inputs.size());
  for (const double x : inputs) {
    state->go(x);
    outputs.push_back(state->output_at(x));
  }
  return outputs;
}

std::vector<double> invert(const HysteresisModel& model, std::span<const double> outputs) {
  const auto state = model.state();
  std::vector<double> inputs;
  inputs.reserve(outputs.size());
  for (const double y : outputs) {
    if (!std::isfinite(y)) throw std::invalid_argument("an output is not a finite number");
    inputs.push_back(state->input_at(y));
    state->go(inputs.back());
  }
  return inputs;
}

}  // namespace tactbench::analysis
