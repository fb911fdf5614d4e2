// What the streams of a dynamic model leave of pressures on paths that were not fitted, by level and direction: for the
// uncertainty of compensated values.
#pragma once

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Fills in residual_shape and the taxels' residual_psi of `model`, which was fitted to `undone` with `fit`: the outputs
// of `fitted` with lag and creep undone. Where `fitted` has sequences of two or more names that all go over its whole
// range, each half of them is read with a model of the other half, and what these streams leave, root mean square, is
// the residual. Otherwise, and for taxels that such a half does not tell, it is twice what the model's own stream
// leaves.
void find_dynamic_residuals(const Dataset& fitted, const Dataset& undone, const FitOptions& fit, SensorModel& model);

}  // namespace tactbench::analysis
