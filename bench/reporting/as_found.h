// Judges a sensor as found: this run's data with the models that were in use before it, by the report's limits.
#pragma once

#include <string>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"

namespace tactbench::bench {

// The models that the sensor had before `run`, as RUN:FIT; empty: the store has none, or they do not go together with
// it (another scanner), or they rest on it.
std::string models_before(analysis::Runs& runs, std::int64_t run);

// Fills in `judgement` and `doubt` of input.more.previous, where there are earlier models (`previous`, as named) and
// the report is judged by `limits`. When it fails, measurements made since the last calibration of this sensor that
// passed are in doubt.
void judge_as_found(analysis::Runs& runs, analysis::ReportInput& input, const std::string& previous,
                    const analysis::Limits& limits);

}  // namespace tactbench::bench
