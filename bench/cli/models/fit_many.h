// `fit 1-400`: fits the same models to each of several runs, one output line per run.
#pragma once

#include <string>

#include "bench/cli/models/fit_models.h"

namespace tactbench::bench {

// Whether `source` is a list of runs: 12-55, or 1-3,7. A single number is not.
bool names_runs(const std::string& source);

// Fits the runs of `options.source` that are in the store, have ended, are not void (unless void runs are included) and
// have frames. Runs that cannot be fitted are reported, and the exit code is then 6.
void fit_many(const FitModelsOptions& options, Session& session);

}  // namespace tactbench::bench
