// Volts per count of the scanner with which a run was recorded.
#pragma once

#include "db/record.h"

namespace tactbench::analysis {

// From the run's scanner calibration. Throws AnalysisError TB-ANALYSIS-NO-CALIBRATION.
double volts_per_count(const db::RunRecord& run);

}  // namespace tactbench::analysis
