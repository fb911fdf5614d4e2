// Whether models may speak of a run.
#pragma once

#include "analysis/dataset.h"
#include "analysis/identify/identify.h"

namespace tactbench::analysis {

// A model is bound to sensor, scanner and geometry, and origins never mix. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
void check_same_sensor(const Dataset& dataset, const ArrayFit& fit);

}  // namespace tactbench::analysis
