// Prediction interval of a figure from earlier runs, to detect gross changes, and the slope of a sequence of runs.
#pragma once

#include <optional>
#include <span>

namespace tactbench::analysis {

// Prediction interval for one further value of a normal sample: mean -+ t(1 - alpha/2, n - 1) s sqrt(1 + 1/n)
// (Hahn and Meeker, Statistical Intervals, 4.7). All in the values' unit.
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

// Theil-Sen slope of values in time order, a run: the median of (x_j - x_i) / (j - i), i < j (Sen 1968, J. Am. Stat.
// Assoc. 63, 1379). A description, no test. None from fewer than four values or from one that is not finite.
std::optional<double> theil_sen_slope(std::span<const double> values);

}  // namespace tactbench::analysis
