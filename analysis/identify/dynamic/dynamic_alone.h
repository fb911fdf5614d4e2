// Fits the dynamic Preisach model to a single run, with lag and creep estimated from that run; and states which of the
// two a dynamic model compensates.
#pragma once

#include "analysis/identify/dynamic/dynamic_fit.h"

namespace tactbench::analysis {

// Like fit_dynamic() with the run itself as rate and creep run: lag where its repeats differ in pace, creep from its
// holds or, without any, as in own_creep.h. Neither is compensated where the run does not begin at 0 psi. Throws as
// fit_array does.
SensorModel fit_dynamic_alone(const Dataset& fitted, const DynamicFitOptions& options = {});

// The same for a table whose histories have times (HistoriesOptions::timed). Throws AnalysisError TB-ANALYSIS-DYNAMICS
// where the lowest input is not 0 or taxels have inputs of their own, and as fit_array does.
SensorModel fit_dynamic_table(const Histories& histories, const DynamicFitOptions& options = {});

// True when its creep is the single share estimated from the fitted run, not from holds.
bool creep_of_fitted_run(const SensorDynamics& dynamics);
bool undoes_creep(const SensorDynamics& dynamics);
bool undoes_lag(const SensorDynamics& dynamics);
// True when its compensator needs the times of the samples.
bool in_time(const SensorDynamics& dynamics);

}  // namespace tactbench::analysis
