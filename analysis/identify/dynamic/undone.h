// Removes a dynamic model's lag and creep from measured histories, so that they can be compared with, or used to
// adjust, its static taxel models.
#pragma once

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Returns the outputs without the model's creep, at the inputs that have arrived, computed along the measured inputs.
// The histories of a run follow each other, including the conditioning between them; those of a table each begin at
// rest. Histories of taxels that the model lacks or did not fit are unchanged. For a model with dynamics. Throws
// AnalysisError TB-MODEL-DYNAMIC where samples lack the times that it needs, and as compensator_of does.
Histories creep_and_lag_undone(const SensorModel& model, Histories histories);

}  // namespace tactbench::analysis
