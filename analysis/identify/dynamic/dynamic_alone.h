// The dynamic Preisach model of one run, with the creep that the run tells and without lag; and which of the two a
// dynamic model undoes.
#pragma once

#include "analysis/identify/dynamic/dynamic_fit.h"

namespace tactbench::analysis {

// As fit_dynamic() with lag left in the outputs. Creep is that of own_creep.h; it is left in where the run does not
// begin at 0 psi, or tells none. Throws as fit_array does.
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
