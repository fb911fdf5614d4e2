// The dynamic Preisach model of one run, with the lag and creep that the run tells; and which of the two a dynamic
// model undoes.
#pragma once

#include "analysis/identify/dynamic/dynamic_fit.h"

namespace tactbench::analysis {

// As fit_dynamic() of the run and itself: lag where repeats of it differ in pace, creep of its holds or, without any,
// that of own_creep.h. Both are left in where it does not begin at 0 psi. Throws as fit_array does.
SensorModel fit_dynamic_alone(const Dataset& fitted, const DynamicFitOptions& options = {});

// Of a table whose histories tell their times (HistoriesOptions::timed): creep and lag as they are found there.
// Throws AnalysisError TB-ANALYSIS-DYNAMICS where the lowest input is not 0 or taxels have inputs of their own, and as
// fit_array does.
SensorModel fit_dynamic_table(const Histories& histories, const DynamicFitOptions& options = {});

// Its creep is the one share that the fitted run tells, not that of holds.
bool creep_of_fitted_run(const SensorDynamics& dynamics);
bool undoes_creep(const SensorDynamics& dynamics);
bool undoes_lag(const SensorDynamics& dynamics);
// Its stream is to be told the times.
bool in_time(const SensorDynamics& dynamics);

}  // namespace tactbench::analysis
