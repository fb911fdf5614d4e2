// Arrays under objects, and where the inverse is well-conditioned, on shapes whose answer is known.
#include "analysis/statistics/studies/contact_results.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "analysis/statistics/figures/usable_range.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench::analysis;

TEST_CASE("force, centre, moments and area of a block of pressure") {
  const ArrayGeometry geometry{2.0, 3.0};  // mm, mm^2
  std::vector<double> pressure(6 * 8, 0.0);
  for (const int row : {1, 2})
    for (const int column : {5, 6}) pressure[static_cast<std::size_t>(row * 8 + column)] = 20.0;
  pressure[0] = 1.0;  // below 10 % of the peak: no contact
  pressure[47] = std::numeric_limits<double>::quiet_NaN();
  const ContactFigures f = contact_figures(pressure, 6, 8, geometry);
  const double newton = 3.0 * kNewtonPerPsiMm2;
  CHECK(f.force_n == Approx(81.0 * newton).epsilon(1e-12));
  CHECK(f.area_mm2 == Approx(12.0));
  CHECK(f.threshold_psi == Approx(2.0));
  // Block's centre (column 5.5, row 1.5) at (4, -2) mm; the odd taxel pulls at nothing.
  CHECK(f.x_mm == Approx(4.0).epsilon(1e-12));
  CHECK(f.y_mm == Approx(-2.0).epsilon(1e-12));
  CHECK(f.moment_x_nmm == Approx(80.0 * newton * -2.0).epsilon(1e-12));
  CHECK(f.moment_y_nmm == Approx(-80.0 * newton * 4.0).epsilon(1e-12));
  CHECK(std::isnan(contact_figures(std::vector<double>(48, 0.0), 6, 8, geometry).x_mm));
  CHECK_THROWS_AS(contact_figures(pressure, 6, 7, geometry), std::invalid_argument);
}

namespace {

// Straight loops, 0.05 V/psi; the second taxel flat above 40 psi on the way down.
SensorModel two_taxel_fit() {
  SensorModel fit;
  fit.rows = 1;
  fit.columns = 2;
  fit.origin = "simulated";
  fit.sensor_serial = "S";
  std::vector<double> up, flat;
  for (int i = 0; i <= 6; ++i) {
    fit.pressure_psi.push_back(10.0 * i);
    up.push_back(0.5 * i);
    flat.push_back(i <= 4 ? 0.74 * i : 2.96 + 0.02 * (i - 4));
  }
  flat.back() = 3.0;
  for (const auto& down : {up, flat}) {
    ModelTaxel taxel = by_hand::elam_taxel(PatternCurve(fit.pressure_psi, up, 0.0, 3.0),
                                           PatternCurve(fit.pressure_psi, down, 0.0, 3.0));
    taxel.noise = 0.002;
    taxel.fit.mean_error = 0.01;
    fit.taxels.push_back(taxel);
  }
  by_hand::finish(fit, fit.taxels.front());
  return fit;
}

}  // namespace

TEST_CASE("an array under an object, read raw and compensated") {
  const SensorModel fit = two_taxel_fit();
  PressRun run;
  run.run = 9;
  run.origin = "simulated";
  run.sensor_serial = "S";
  run.rows = 1;
  run.columns = 2;
  const auto press = [&](int repeat, bool rising, double target, double volts) {
    PressFrame frame;
    frame.repeat = repeat;
    frame.rising = rising;
    frame.target_n = target;
    frame.force_n = target + 0.01;
    frame.volts = {volts, volts};
    run.frames.push_back(frame);
  };
  for (const int repeat : {0, 1}) {
    press(repeat, true, 1.0, 1.0);
    press(repeat, true, 2.0, 2.0);
    press(repeat, false, 1.0, 1.0);
  }
  const ContactResult result = contact_result(run, fit, {2.0, 10.0});
  REQUIRE(result.levels.size() == 3);
  CHECK(result.repeats == 2);
  CHECK(result.positions == 1);
  const ContactLevel& up = result.levels.front();
  CHECK(up.frames == 2);
  CHECK(up.force_n == Approx(1.01));
  // 1 V is 20 psi on the line and on the way up of either taxel.
  CHECK(up.raw.force_n == Approx(2 * 20.0 * 10.0 * kNewtonPerPsiMm2));
  CHECK(up.compensated.force_n == Approx(up.raw.force_n).epsilon(0.01));
  CHECK(up.raw_force_error_n == Approx(std::abs(up.raw.force_n - 1.01)));
  CHECK(up.raw_std == Approx(0.0).margin(1e-12));
  CHECK(up.compensated.x_mm == Approx(0.0).margin(1e-9));
  CHECK(std::isnan(up.raw_place_error_mm));
  CHECK(result.raw_distance[0] == Approx(0.0).margin(1e-12));
  CHECK(std::isnan(result.raw_distance[1]));  // the peak has no frame on its way down
  CHECK(result.raw_max_error_n >= result.raw_mean_error_n);

  PressRun other = run;
  other.sensor_serial = "another";
  CHECK_THROWS_AS(contact_result(other, fit, {}), AnalysisError);
}
