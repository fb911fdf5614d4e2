// Prediction interval of a figure from earlier runs, and a test for a monotone trend.
#pragma once

#include <optional>
#include <span>

namespace tactbench::analysis {

// Prediction interval for one further value of a normal sample: mean -+ t(1 - alpha/2, n - 1) s sqrt(1 + 1/n)
// (Hahn and Meeker, Statistical Intervals, 4.7).
struct ControlBand {
  double mean = 0.0, deviation = 0.0;  // deviation: of the sample, n - 1
  double low = 0.0, high = 0.0;
  int values = 0;
  [[nodiscard]] bool holds(double value) const { return value >= low && value <= high; }
};

// `false_alarm`: alpha, the probability that a value of the same kind falls outside. Equal values give a band of
// rounding width (1e-9 of the value): any change is outside. None from fewer than three values or from one that is not
// finite.
std::optional<ControlBand> control_band(std::span<const double> values, double false_alarm);

// Mann-Kendall test for a monotone trend of values in time order, and the Theil-Sen slope.
struct MonotoneTrend {
  double probability = 1.0;  // of an order at least as clear, in either direction, without a trend
  double slope = 0.0;        // median of (x_j - x_i) / (j - i), i < j
  double moved = 0.0;        // slope x (n - 1)
};

// Exact up to twenty values without ties (Kendall's distribution), else the normal approximation with correction for
// ties and continuity. None from fewer than four values or from one that is not finite.
std::optional<MonotoneTrend> monotone_trend(std::span<const double> values);

}  // namespace tactbench::analysis
