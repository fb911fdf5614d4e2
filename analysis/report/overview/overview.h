// Pages on several runs: two beside each other, or a batch of sensors. Each run as its own report has it.
#pragma once

#include <vector>

#include "analysis/report/report.h"

namespace tactbench::analysis {

// As found and as left, or two sensors. first.held_out may hold the second run's data compensated with the first run's
// models: as found. Where one has no models, what does not need any.
Report render_comparison(const ReportInput& first, const ReportInput& second);

// One page for many sensors: yield, ranks, histograms with limits, outliers, mean loops. Not empty. Of each sensor one
// run stands for it: the newest that counts, one with models before one without.
Report render_batch(const std::vector<ReportInput>& named);
// Places in `named` of the runs that stand for their sensors. A run whose sensor is not stated stands for itself.
std::vector<std::size_t> batch_rows(const std::vector<ReportInput>& named);

// Modified z-score 0.6745 (x - median) / MAD (Iglewicz and Hoaglin 1993); NaN where x is not finite, fewer than five
// values are, or more than half of them are equal.
std::vector<double> modified_z_scores(const std::vector<double>& values);
inline constexpr double kOutlierScore = 3.5;

}  // namespace tactbench::analysis
