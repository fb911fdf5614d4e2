// How corrected readings change when the dwell time is not the calibration's: one loop at several dwell times (the
// recipe `rate`), each reading compared with that of the repeat whose dwell is nearest to the calibration's.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

struct DwellEffect {
  std::string not_assessed = "no run of recipe rate was given, the same loop at several dwell times";
  std::int64_t run = 0;
  double low_s = 0.0, high_s = 0.0;  // shortest and longest dwell: times from command to frame, medians of the repeats
  double base_s = 0.0;               // that of the repeat that the others are set against
  // Levels of the models up, then down, x taxels: the larger over the repeats of the mean square of the change over the
  // window of kHistoryWindowPsi, psi². It contains the noise of two frames. NaN where not fitted.
  std::vector<double> square_psi;
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};

double median_dwell_s(const Dataset& dataset);  // over all frames above kHeldAbovePsi; NaN where none states it

// From the first of `runs` with repeats whose dwell times differ by a factor of two. Outputs rising (as_modelled).
DwellEffect dwell_effect_of(const Dataset& calibration, std::span<const Dataset* const> runs, const SensorModel& fit,
                            int threads = 0);

}  // namespace tactbench::analysis
