// Report pages on several runs: a comparison of two, or a batch of sensors. Each run's figures are those of its own
// report.
#pragma once

#include <vector>

#include "analysis/report/report.h"

namespace tactbench::analysis {

// As found and as left, or two sensors. first.held_out may hold the second run's data compensated with the first run's
// models: as found. When one run has no models, only the parts that need none.
Report render_comparison(const ReportInput& first, const ReportInput& second);

// One page for many sensors: yield, ranks, histograms with limits, outliers, mean loops. Not empty. Each sensor is
// represented by one run: the newest that counts, preferably one with models.
Report render_batch(const std::vector<ReportInput>& named);
// Indices in `named` of the runs that represent their sensors. A run without a sensor represents itself.
std::vector<std::size_t> batch_rows(const std::vector<ReportInput>& named);

// Modified z-score 0.6745 (x - median) / MAD (Iglewicz and Hoaglin 1993); NaN where x is not finite, fewer than five
// values are, or more than half of them are equal.
std::vector<double> modified_z_scores(const std::vector<double>& values);
inline constexpr double kOutlierScore = 3.5;

}  // namespace tactbench::analysis
