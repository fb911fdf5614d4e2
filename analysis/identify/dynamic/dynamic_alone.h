// The dynamic Preisach model of one run, without lag and creep; and which of the two a dynamic model undoes.
#pragma once

#include "analysis/identify/dynamic/dynamic_fit.h"

namespace tactbench::analysis {

// As fit_dynamic() with lag and creep left in the outputs: Preisach on the linearised output for the dynamic stream.
// Throws as fit_array does.
SensorModel fit_dynamic_alone(const Dataset& fitted, const DynamicFitOptions& options = {});

bool undoes_creep(const SensorDynamics& dynamics);
bool undoes_lag(const SensorDynamics& dynamics);
// Its stream is to be told the times.
bool in_time(const SensorDynamics& dynamics);

}  // namespace tactbench::analysis
