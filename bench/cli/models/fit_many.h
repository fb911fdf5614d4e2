// `fit 1-400`: the same models for each of several runs, one line a run.
#pragma once

#include <string>

#include "bench/cli/models/fit_models.h"

namespace tactbench::bench {

// Whether `source` is a list of runs: 12-55, or 1-3,7. A single number is not.
bool names_runs(const std::string& source);

// Fits the runs of `options.source` that are in the store, have ended and are neither void (unless taken) nor without
// frames. What cannot be fitted is named, and the exit code is 6 then.
void fit_many(const FitModelsOptions& options, Session& session);

}  // namespace tactbench::bench
