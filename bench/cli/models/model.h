// `model diff`, and the conversion of a model's inputs and parameters to the display unit of pressure.
#pragma once

#include <string>

#include "analysis/identify/sensor_model.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

// The displayed unit of a model's inputs, and the factor from the model's own unit to it. Only pressures are converted.
struct ShownInput {
  std::string unit;
  double factor = 1.0;
};
ShownInput shown_input(const analysis::SensorModel& model, analysis::PressureUnit unit);

// "1/x" becomes "1/psi" if the model has the units of its input x and its output y.
std::string parameter_unit(const std::string& unit, const analysis::SensorModel& model, const ShownInput& input);
// The factor by which a parameter with the unit "x", "1/x" or "y/x^3" is multiplied for display.
double parameter_factor(const std::string& unit, const ShownInput& input);

// Prints the differences of the parameters of two models (names as `model diff` takes them) and sets the exit code: 1
// if they differ. Throws TB-MODEL-DIFF for models of different kinds.
void diff_models(const std::string& first, const std::string& second, Session& session);

}  // namespace tactbench::bench
