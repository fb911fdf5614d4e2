#include "analysis/models/model.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

bool ModelParameter::at_bound() const {
  constexpr double kNear = 1e-9;
  const double distance = std::isfinite(high - low) ? high - low : 1.0;
  return value - low <= kNear * distance || high - value <= kNear * distance;
}

ModelMembers range_and_parameters(const HysteresisModel& model, double y_low) {
  ModelMembers members = {{"x_low", model.x_low()}, {"x_high", model.x_high()}, {"y_low", y_low}};
  for (const ModelParameter& parameter : model.parameters())
    members.emplace_back("parameters/" + parameter.name, parameter.value);
  return members;
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
