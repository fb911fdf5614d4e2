// Selects the model of `fit` if none is named: the dynamic model, or ELAM for data that the dynamic model does not
// accept.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "bench/cli/models/fit_models.h"
#include "bench/common/work_progress.h"

namespace tactbench::bench {

// Why ELAM is used; empty: the dynamic model is used.
std::string why_elam(const FitModelsOptions& options, const analysis::Histories& fitted);

// True when the data of the dynamic model do not determine the inner branches.
bool without_inner_branches(const analysis::SensorModel& dynamic);

// Progress stages for fitting `models`; if empty, the stages that suit either choice.
std::vector<WorkStage> fit_stages(const std::vector<std::string>& models);
inline constexpr const char* kFiguresStage = "figures";  // the last stage: cross-validation, evaluation, judgement

// Whether `source` is a list of runs: 12-55, or 1-3,7. A single number is not.
bool is_run_list(const std::string& source);

}  // namespace tactbench::bench
