// The dynamic Preisach model of an array: lag and creep from runs that vary time, then for each taxel the divider by
// the congruency test and Preisach's weights on its linearised output.
#pragma once

#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr const char* kDynamicModel = "dynamic";  // SensorModel::model

struct DynamicFitOptions {
  int cells = 20;        // Preisach's intervals of the input range; no more than the fitted run's levels have
  int threads = 0;       // 0: as many as there are cores
  bool by_input = true;  // IdentifyOptions::by_input
};

// The taxels' models and figures are of the static film: outputs of `fitted` with creep removed, at the pressures that
// have arrived. Validity covers the holds and rates of all three runs. `rate` and `creep` may be one run. Content
// hashes are left empty, because a Dataset does not have them. Deterministic; threads by taxel. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR and TB-ANALYSIS-ORIGIN where a run is of another array or origin than `fitted`,
// TB-ANALYSIS-DYNAMICS where `creep` holds no level or `rate` has no two rates, and as fit_array does.
SensorModel fit_dynamic(const Dataset& fitted, const Dataset& rate, const Dataset& creep,
                        const DynamicFitOptions& options = {});

// Fits the dynamic Preisach model to a single run, with lag and creep estimated from that run; and states which of the
// two a dynamic model compensates.

// Like fit_dynamic() with the run itself as rate and creep run: lag where its repeats differ in pace, creep from its
// holds or, without any, as in dynamics_search.h. Neither is compensated where the run does not begin at 0 psi. Throws
// as fit_array does.
SensorModel fit_dynamic_single_run(const Dataset& fitted, const DynamicFitOptions& options = {});

// The same for a table whose histories have times (HistoriesOptions::timed). Throws AnalysisError TB-ANALYSIS-DYNAMICS
// where the lowest input is not 0 or taxels have inputs of their own, and as fit_array does.
SensorModel fit_dynamic_table(const Histories& histories, const DynamicFitOptions& options = {});

bool compensates_creep(const SensorDynamics& dynamics);
bool compensates_lag(const SensorDynamics& dynamics);
// True when its compensator needs the times of the samples.
bool in_time(const SensorDynamics& dynamics);

// Removes a dynamic model's lag and creep from measured histories, so that they can be compared with, or used to
// adjust, its static taxel models.

// Returns the outputs without the model's creep, at the inputs that have arrived, computed along the measured inputs.
// The histories of a run follow each other, including the conditioning between them; those of a table each begin at
// rest. Histories of taxels that the model lacks or did not fit are unchanged. For a model with dynamics. Throws
// AnalysisError TB-MODEL-DYNAMIC where samples lack the times that it needs, and as compensator_of does.
Histories histories_without_dynamics(const SensorModel& model, Histories histories);

}  // namespace tactbench::analysis
