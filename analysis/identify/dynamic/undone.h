// Measured histories as the static film of a dynamic model has them: for comparing its taxels' models with data, and
// adjusting them.
#pragma once

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// The outputs with the creep of the model undone, at the inputs that have arrived, along the inputs measured. A run's
// histories follow each other, conditioning between them included; a table's begin at rest. Histories of taxels that
// the model does not have or fit stay as they are. Of a model with dynamics. Throws AnalysisError TB-MODEL-DYNAMIC
// where samples tell no times that it needs, and as compensator_of does.
Histories creep_and_lag_undone(const SensorModel& model, Histories histories);

}  // namespace tactbench::analysis
