// A dynamic model as the streaming compensator takes it.
#pragma once

#include <span>

#include "analysis/compensate/dynamic_setup.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Of the given taxels of a model with dynamics, in their order; those that are not fitted are not usable. What `model
// adjust` moved is contained. `noisier`: by how much more noise a sample has than those that were fitted. Throws
// AnalysisError TB-MODEL-COMPENSATOR when the model has no dynamics, or a taxel's is not Preisach on the linearised
// output, or they do not share one range and number of intervals.
DynamicSetup dynamic_setup_of(const SensorModel& model, std::span<const ModelTaxel> taxels, double volts_per_count,
                              double noisier = 1.0);

}  // namespace tactbench::analysis
