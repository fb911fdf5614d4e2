// Residuals of a dynamic model's compensators in pressure on paths that were not fitted, by level and direction: for
// the uncertainty of compensated values.
#pragma once

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Fills in residual_shape and the taxels' residual_psi of `model`, which was fitted to `undone` with `fit`: the outputs
// of `fitted` with lag and creep removed. As of any model (residuals.h), in time: streams of models that did not see a
// part of the inner branches read the whole run, and their errors on that part count. The shape is the root of half 1
// and half those errors' squares by interval, of both directions apart and smoothed, over their mean: few branches tell
// an interval. It is 1 where no inner branch tells.
void find_dynamic_residuals(const Dataset& fitted, const Dataset& undone, const FitOptions& fit, SensorModel& model);

}  // namespace tactbench::analysis
