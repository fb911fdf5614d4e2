// What share of corrected readings lies within the report's own U of the truth, on simulated sensors: the plant's
// pressure, which neither models nor budgets see.
#pragma once

#include <string>
#include <vector>

#include "bench/config/specimen_options.h"
#include "tests/benchmarks/study/figure.h"

namespace tactbench::bench {

struct CoverageOptions {
  std::vector<unsigned> sensor_seeds;
  std::vector<SpecimenKind> specimens = {SpecimenKind::kPaper, SpecimenKind::kHarsh, SpecimenKind::kFoam};
  bool production = true, table_1 = true;  // calibrations
  bool elam = true, dynamic = true;        // models
};

// For each specimen, calibration, model and condition of use: coverage in % of (taxel, frame) pairs, the median U and
// the half-width of the smallest interval about 0 that covers 95 % of the same errors; or how many sensors the report
// calls U not valid for. Runs are made in `folder`.
std::vector<Figure> benchmark_coverage(const CoverageOptions& options, const std::string& folder);

}  // namespace tactbench::bench
