// Report pages on several runs: a comparison of two, or a batch of sensors. The figures of each run are those of its
// own report.
#pragma once

#include <vector>

#include "analysis/report/report.h"

namespace tactbench::analysis {

// Compares a sensor as found and as left, or two sensors. first.held_out may contain the second run's data compensated
// with the first run's models (as found). If one run has no models, only the parts that need none are shown.
Report render_comparison(const ReportInput& first, const ReportInput& second);

// One page for many sensors: yield, ranks, histograms with limits, outliers, mean loops. `named` must not be empty.
// Each sensor is represented by one run: its newest valid run, preferably one with models.
Report render_batch(const std::vector<ReportInput>& named);
// Indices in `named` of the runs that represent their sensors. A run without a sensor counts as a separate sensor.
std::vector<std::size_t> batch_rows(const std::vector<ReportInput>& named);

// Modified z-score 0.6745 (x - median) / MAD (Iglewicz and Hoaglin 1993); NaN if x is not finite, fewer than five
// values are finite, or more than half of them are equal.
std::vector<double> modified_z_scores(const std::vector<double>& values);
inline constexpr double kOutlierScore = 3.5;

}  // namespace tactbench::analysis
