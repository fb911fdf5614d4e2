// Calibration of the pressure reference against a hand gauge: from readings at rising and falling levels to
// corrections, residuals and an expanded uncertainty. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "devices/pressure/pressure_reference.h"

namespace tactbench::bench {

struct GaugePoint {
  double level_psi = 0.0;      // commanded
  bool rising = true;          // approached from below
  double reference_psi = 0.0;  // uncorrected
  double gauge_psi = 0.0;      // as the operator read it
};

struct ReferenceCalibration {
  devices::PressureCorrection correction;  // by level, rising readings
  std::vector<double> residual_psi;        // one per point: gauge - corrected reference
  double largest_residual_psi = 0.0;
  double hysteresis_psi = 0.0;  // largest difference of correction between up and down at one level
};

// Correction at a level: mean of (gauge - reference) over its points, up and down. Expanded uncertainty (k = 2) by GUM
// F.2.3: u² = u_gauge² + (half of the up-down difference)²/3 + (resolution of the gauge)²/12. Needs two levels or more;
// throws std::invalid_argument otherwise, and Error (TB-REFERENCE-FLAT) where the mean readings of the reference or of
// the gauge do not rise from level to level.
ReferenceCalibration calibrate_reference(const std::vector<GaugePoint>& points, double gauge_expanded_uncertainty_psi,
                                         double gauge_resolution_psi);

// The table that [reference] correction_file names, with the readings that it came from as comments.
std::string correction_toml(const ReferenceCalibration& calibration, const std::vector<GaugePoint>& points,
                            const std::string& heading);

}  // namespace tactbench::bench
