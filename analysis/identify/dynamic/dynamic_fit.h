// The dynamic Preisach model of an array: lag and creep from runs that vary time, then for each taxel the divider by
// the congruency test and Preisach's weights on its linearised output.
#pragma once

#include "analysis/compensate/dynamic_setup.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/elam/identify.h"

namespace tactbench::analysis {

struct DynamicFitOptions {
  int cells = 20;   // Preisach's intervals of the input range
  int threads = 0;  // 0: as many as there are cores
  bool linearise = true;
  bool by_input = true;  // IdentifyOptions::by_input
};

struct DynamicFit {
  ArrayDynamics dynamics;
  DynamicSetup setup;                // volts_per_count is left 0: the caller's converter
  std::vector<double> mean_error_v;  // per taxel of the direct model on what was fitted, creep and lag undone
};

// `rate` and `creep` may be null (find_dynamics). Throws AnalysisError as histories_of and fit_data_of do.
DynamicFit fit_dynamic(const Dataset& fitted, const Dataset* rate, const Dataset* creep,
                       const DynamicFitOptions& options = {});

}  // namespace tactbench::analysis
