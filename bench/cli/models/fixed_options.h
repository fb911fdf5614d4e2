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

// --frame-rate, --per-count, --noise and --scans: the same values as in the export of the device's model.
void add_device_options(CLI::App& verb, analysis::FixedOptions& options);
// --as, and the options of add_device_options().
void add_fixed_options(CLI::App& verb, FixedWords& text);

// `name`: MODEL of the command line. Without --per-count the volts per count of a stored run's scanner are used.
// Throws AnalysisError TB-MODEL-FIXED.
analysis::FixedModel fixed_model(const std::string& name, const analysis::SensorModel& model,
                                 analysis::FixedOptions options, const Session& session);

}  // namespace tactbench::bench
