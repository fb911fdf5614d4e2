// Residuals of a dynamic model's compensators in pressure on paths that were not fitted, by level and direction: for
// the uncertainty of compensated values.
#pragma once

#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Fills in residual_shape and the taxels' residual_psi of `model`, which was fitted to `undone` with `fit`: the outputs
// of `fitted` with lag and creep removed. As of any model (residuals.h), in time: streams of models that did not see a
// part of the inner branches read the whole run, and their errors on that part count. The shape is the root of half 1
// and half those errors' squares by interval, of both directions apart and smoothed, over their mean: few branches
// cover an interval. It is 1 if no inner branch covers it.
void find_dynamic_residuals(const Dataset& fitted, const Dataset& undone, const FitOptions& fit, SensorModel& model);

// Removes a dynamic model's lag and creep from measured histories, so that they can be compared with, or used to
// adjust, its static taxel models.

// Returns the outputs without the model's creep, at the inputs that have arrived, computed along the measured inputs.
// The histories of a run follow each other, including the conditioning between them; those of a table each begin at
// rest. Histories of taxels that the model lacks or did not fit are unchanged. For a model with dynamics. Throws
// AnalysisError TB-MODEL-DYNAMIC where samples lack the times that it needs, and as compensator_of does.
Histories histories_without_dynamics(const SensorModel& model, Histories histories);

}  // namespace tactbench::analysis
