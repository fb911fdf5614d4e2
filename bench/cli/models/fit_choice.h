// Which model `fit` makes where none is named: the dynamic model, or ELAM of what that does not take.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "bench/cli/models/fit_models.h"
#include "bench/common/long_work.h"

namespace tactbench::bench {

// Why ELAM is made; empty: the dynamic model is.
std::string why_elam(const FitModelsOptions& options, const analysis::Histories& fitted);

// The dynamic model's data leave the inner branches open.
bool without_inner_branches(const analysis::SensorModel& dynamic);

// Of the work on `models`; none is named: of either.
std::vector<WorkStage> fit_stages(const std::vector<std::string>& models);
inline constexpr const char* kFiguresStage = "figures";  // the last: cross-validation, evaluation, judgement

}  // namespace tactbench::bench
