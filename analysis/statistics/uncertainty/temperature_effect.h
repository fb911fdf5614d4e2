// Contribution of temperature to the uncertainty of a reading: the change of the output per kelvin, from runs of one
// sensor at several temperatures, over the temperatures of the calibration. Datasets in, a coefficient with its
// standard uncertainty out, used by the uncertainty budgets.
#pragma once

#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

inline constexpr double kOtherTemperatureK = 2.0;  // means of two runs' readings that differ by this are two

// A change of the output: `zero_v` volts, and `share` of the output over its zero.
struct OutputChange {
  double zero_v = 0.0, share = 0.0;
};

struct TemperatureEffect {
  std::string not_assessed = "no run of this sensor at another temperature shows its effect";  // empty: assessed
  std::vector<double> temperature_c;  // of each run, the calibration first: mean of its readings
  // Of the mean taxel over its external loop, against as many first repeats of the calibration.
  std::vector<OutputChange> change;
  // A kelvin, of the mean taxel: slope of the above over temperature. u: the larger of what the scatter of the repeats
  // and the scatter of the runs about the line give. deviation: of single taxels' own slopes from the mean's.
  OutputChange per_kelvin, u, deviation;
  bool from_repeats = true;  // u is that of the repeats: two runs, or runs that lie on a line as well as repeats do
  double dof = 0.0;          // of u
  double low_c = 0.0, high_c = 0.0, resolution_c = 0.0;  // of the calibration's readings
  double thermometer_u_c = 0.0;                          // of the thermometer's own calibration; 0: not stated
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
  // Of a rectangle: the readings' range and step, and what the thermometer itself is off by, of the same variance.
  [[nodiscard]] double half_width_c() const {
    return std::hypot(0.5 * (high_c - low_c + resolution_c), std::numbers::sqrt3 * thermometer_u_c);
  }
  // Half-width in volt at an output so far over its zero: half_width_c times the root of the squares of coefficient,
  // its u and the taxels' deviation.
  [[nodiscard]] double width_v(double over_zero_v) const;
  [[nodiscard]] std::string display_text()
      const;  // what was found, and what is not kept apart; empty when not assessed
};

double mean_temperature_c(const Dataset& dataset);  // NaN without readings
// Both runs have readings, and their means differ by kOtherTemperatureK.
bool at_another_temperature(std::span<const double> calibration_c, std::span<const double> other_c);

// `others`: of the same sensor, mounted once and not aged between, which the caller knows. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
TemperatureEffect temperature_effect_of(const Dataset& calibration, std::span<const Dataset> others,
                                        const SensorModel& fit, double resolution_c, double thermometer_u_c = 0.0);

}  // namespace tactbench::analysis
