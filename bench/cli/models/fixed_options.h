// Options of verbs that run or write a model in a device's integers: --as fixed, model export --format c.
#pragma once

#include <string>

#include "analysis/export/quantise.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

struct FixedWords {
  std::string as = "double";
  analysis::FixedOptions options;
};

// --frame-rate, --per-count, --noise and --scans, which must be those that a device's model was exported with.
void add_device_options(CLI::App& verb, analysis::FixedOptions& options);
// --as, and those.
void add_fixed_options(CLI::App& verb, FixedWords& words);

// `name`: MODEL of the command line; of a run of the store its scanner says what a count is, where no option does.
// Throws AnalysisError TB-MODEL-FIXED.
analysis::FixedModel fixed_model(const std::string& name, const analysis::SensorModel& model,
                                 analysis::FixedOptions options, const Session& session);

}  // namespace tactbench::bench
