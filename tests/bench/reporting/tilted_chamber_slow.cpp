// A chamber that presses one edge more than the other: four runs of one sensor turned in it tell its map from the
// sensor's, as the report takes them apart.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "bench/reporting/evaluation.h"
#include "bench/run/recipe_check.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

constexpr double kTilt = 0.04, kTiltDeg = 30.0;

// Right and up from the array's centre, of its side.
double right_of(int taxel) { return (taxel % 16 - 7.5) / 15.0; }
double up_of(int taxel) { return (7.5 - taxel / 16) / 15.0; }  // NOLINT(bugprone-integer-division): rows are whole

double planted_share(double tilt, int cell) {
  const double angle = kTiltDeg * std::numbers::pi / 180.0;
  return tilt * (right_of(cell) * std::cos(angle) + up_of(cell) * std::sin(angle));
}

// Four characterizations at the report's angles and the report's study of them.
analysis::ReportInput turned_runs(double tilt) {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  for (int turn = 0; turn < 4; ++turn) {
    bench::RunRequest request = small_request({{"simulation.effects.chamber_tilt", std::to_string(tilt)},
                                               {"simulation.effects.chamber_tilt_deg", std::to_string(kTiltDeg)},
                                               {"simulation.turned_in_chamber_deg", std::to_string(90 * turn)}},
                                              {static_cast<std::uint64_t>(turn) + 1, 5});
    request.recipes = bench::read_recipes({"descending"}, {{"repeats", "1"}});
    request.check_seating = true;
    const bench::RunResult result = run_small(request, store);
    INFO((result.error ? result.error->what() : ""));
    REQUIRE(!result.error);
  }
  analysis::Runs runs(store);
  const analysis::SensorModel fit = bench::fit_run(store, runs.dataset(1));
  bench::ReportExtras extras;
  extras.studies = {"2:90", "3:180", "4:270"};
  return bench::report_input(runs, 1, fit, bench::evaluate_runs(runs, fit, {}), {}, {}, &extras);
}

// The plane through a map: relative pressure difference over the array's side along both axes.
struct Plane {
  double right = 0.0, up = 0.0;
};
Plane plane_through(const std::vector<double>& shares) {
  Plane plane;
  double squares = 0.0;
  for (int cell = 0; cell < 256; ++cell) {
    plane.right += shares[static_cast<std::size_t>(cell)] * right_of(cell);
    plane.up += shares[static_cast<std::size_t>(cell)] * up_of(cell);
    squares += right_of(cell) * right_of(cell);
  }
  return {plane.right / squares, plane.up / squares};
}

// Standard uncertainty of one cell's share: the residual that the report states, through the slope over its levels.
// A cell's value is the mean of four equations less that of its set of four: 3/4 of one equation's variance over 4.
double u_of_cell(const analysis::Uniformity& u) {
  double mean = 0.0, spread = 0.0;
  for (const double p : u.pressure_psi) mean += p / static_cast<double>(u.pressure_psi.size());
  for (const double p : u.pressure_psi) spread += (p - mean) * (p - mean);
  return u.residual_rms_psi * std::sqrt(0.75 / 4.0 / spread);
}

double rms_of(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("a tilted chamber's map is found by turning the sensor, and a level chamber has none") {
  const analysis::ReportInput tilted_input = turned_runs(kTilt), level_input = turned_runs(0.0);
  const analysis::Uniformity &tilted = tilted_input.more.studies.uniformity,
                             &level = level_input.more.studies.uniformity;
  REQUIRE(tilted.assessed());
  REQUIRE(level.assessed());
  const double u_cell = u_of_cell(tilted), u_level = u_of_cell(level);
  const Plane found = plane_through(tilted.chamber_share), none = plane_through(level.chamber_share);
  std::vector<double> off_chamber, planted, off_sensor;
  for (int cell = 0; cell < 256; ++cell) {
    const auto at = static_cast<std::size_t>(cell);
    planted.push_back(planted_share(kTilt, cell));
    off_chamber.push_back(tilted.chamber_share[at] - planted.back());
    // The models were made at 0 degrees under the tilt: what they took for the taxel's own is their error.
    off_sensor.push_back(tilted.sensor_share[at] + planted.back() - level.sensor_share[at]);
  }
  const double right = kTilt * std::cos(kTiltDeg * std::numbers::pi / 180.0);
  const double up = kTilt * std::sin(kTiltDeg * std::numbers::pi / 180.0);
  CAPTURE(u_cell, u_level, tilted.u_share, level.u_share, tilted.residual_rms_psi, level.residual_rms_psi);
  // Errors of models are not independent from taxel to taxel: of many cells the plane is no better known than one.
  CHECK(found.right == Approx(right).margin(2.0 * u_cell));
  CHECK(found.up == Approx(up).margin(2.0 * u_cell));
  CHECK(none.right == Approx(0.0).margin(2.0 * u_level));
  CHECK(none.up == Approx(0.0).margin(2.0 * u_level));
  CHECK(2.0 * u_cell < 0.05 * kTilt);
  CHECK(rms_of(off_chamber) < 3.0 * u_cell);
  CHECK(rms_of(off_sensor) < 3.0 * u_cell);
  // What goes into the uncertainty of a reading.
  CHECK(tilted.u_share == Approx(rms_of(planted)).epsilon(0.05));
  CHECK(level.u_share < 0.1 * tilted.u_share);
  CHECK(tilted.residual_rms_psi < 1.5 * level.residual_rms_psi);
  CHECK(tilted.residual_other_sense_psi > 5.0 * tilted.residual_rms_psi);
  CHECK(tilted.pressure_psi.back() < 60.0);
  CHECK_FALSE(analysis::render_report(tilted_input).html.empty());
}
