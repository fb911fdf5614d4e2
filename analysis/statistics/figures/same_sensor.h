// Refuses to apply a model to a run of another sensor, scanner, geometry or origin.
#pragma once

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// A model is bound to sensor, scanner and geometry, and origins never mix. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
void check_same_sensor(const Dataset& dataset, const SensorModel& fit);

}  // namespace tactbench::analysis
