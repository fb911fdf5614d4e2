// A correction of the reference as it is written to its file, computed by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bench/instruments/reference_calibration.h"

using namespace tactbench::bench;

TEST_CASE("a reference's correction: levels up and down, residuals beside a straight line, U with k = 2") {
  const std::vector<GaugePoint> points = {
      {0.0, true, 0.1, 0.2}, {30.0, true, 30.0, 30.3}, {30.0, false, 30.2, 30.4}, {0.0, false, 0.0, 0.2}};
  const ReferenceCalibration calibration = calibrate_reference(points, 0.06, 0.1);
  // u^2 = 0.03^2 (gauge) + 0.05^2 / 3 (up against down) + 0.1^2 / 12 (resolution)
  const double expanded = 2.0 * std::sqrt(0.0009 + 0.0025 / 3.0 + 0.01 / 12.0);
  CHECK(calibration.correction.expanded_uncertainty_psi[0] == Approx(expanded));
  CHECK(calibration.correction.expanded_uncertainty_psi[1] == Approx(expanded));
  CHECK(calibration.hysteresis_psi == Approx(0.1));
  CHECK(calibration.largest_residual_psi == Approx(0.3 - 0.25 + 0.1 * 0.1 / 30.05));
  CHECK(correction_toml(calibration, points, "head") ==
        "# head\n# level psi, direction, reference psi, hand gauge psi, residual psi\n"
        "#    0.000  up       0.1000     0.2000  -0.0502\n"
        "#   30.000  up      30.0000    30.3000  +0.0503\n"
        "#   30.000  down    30.2000    30.4000  -0.0500\n"
        "#    0.000  down     0.0000     0.2000  +0.0500\n"
        "# largest residual 0.0503 psi, largest difference between up and down 0.1000 psi\n"
        "schema = 1\nreading_psi = [0.0500, 30.1000]\ncorrection_psi = [0.1500, 0.2500]\n"
        "expanded_uncertainty_psi = [0.1013, 0.1013]\ncoverage_factor = 2.0\n");
}
