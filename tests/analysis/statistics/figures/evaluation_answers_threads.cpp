// Every figure of an evaluation against answers worked out on paper, on the straight taxels of straight_array.h: going
// up both read the reference, going down they are off by (1, 6) and (3, 1) psi at 40 and 20 psi.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/report/results.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

void check_values(const std::vector<double>& found, const std::vector<double>& wanted) {
  check_alike(found, wanted, 1e-9);
}

// The same with 60 mV of noise at the second taxel: four times that is 0.24 V, 2.4 psi, so that all it says is weak.
SensorModel noisy_fit() {
  SensorModel fit = straight_fit();
  fit.taxels[1].noise = 0.06;
  return fit;
}

}  // namespace

TEST_CASE("figures of a run by hand: averages over levels, taxels and frames") {
  const Evaluation e = evaluate(known_loop(), straight_fit());
  CHECK(e.full_scale_v == Approx(4.5));
  CHECK(e.full_scale_psi == 60.0);
  CHECK(e.frames == 14);
  CHECK(e.excluded_taxels == 1);
  CHECK(e.hysteresis_max_fs == Approx(0.2 / 4.5));
  CHECK(e.hysteresis_mean_fs == Approx((0.2 + 0.125) / 4.5 / 4));
  CHECK(e.raw_distance == Approx((0.2 + 0.125) / 4.5 / 4));
  CHECK(e.comp_distance == Approx((3.5 + 2.0) / 60 / 4));
  CHECK(e.comp_distance_of_mean == Approx((3.5 + 1.0) / 60 / 4));
  // The first taxel's four levels are off by 0, 6, 1, 0 psi in the mean of the repeats, the second's by 0, 1, 3, 0.
  CHECK(e.worst_taxel_distance == Approx((6.0 + 1.0) / 60 / 4));
  // Frames: (1 + 5) and (1 + 7) in seven each, and twice (3 + 1).
  check_values({e.taxel_mean_error_psi[0], e.taxel_mean_error_psi[1]}, {1.0, 4.0 / 7.0});
  CHECK(e.worst_taxel == 0);
  CHECK(e.worst_taxel_mean_error_psi == Approx(1.0));
  CHECK(e.mean_error_psi == Approx(11.0 / 14.0));
  CHECK(e.max_error_psi == Approx(7.0));
  // Nothing is flat: what is observable is all.
  CHECK(e.flat_share == 0.0);
  CHECK(e.comp_distance_observable == Approx(e.comp_distance));
  CHECK(e.mean_error_observable_psi == Approx(11.0 / 14.0));
  CHECK(e.max_error_observable_psi == Approx(7.0));
}

TEST_CASE("a taxel that is weak everywhere is left out of the observable figures, and of no other") {
  const Evaluation e = evaluate(known_loop(), noisy_fit());
  CHECK(e.flat_share == Approx(0.5));
  CHECK(e.comp_distance == Approx(5.5 / 60 / 4));
  CHECK(e.comp_distance_observable == Approx(7.0 / 60 / 4));
  CHECK(e.worst_taxel_distance_observable == Approx(7.0 / 60 / 4));
  CHECK(e.mean_error_psi == Approx(11.0 / 14.0));
  CHECK(e.mean_error_observable_psi == Approx(1.0));
  CHECK(e.max_error_observable_psi == Approx(7.0));
  const LevelFigures& forty = e.levels[2];
  CHECK(forty.flat_taxels == 1);
  CHECK(forty.worst_taxel_distance == Approx(3.0 / 60));
  CHECK(forty.worst_taxel_distance_observable == Approx(1.0 / 60));
  CHECK(forty.comp_distance_observable == Approx(1.0 / 60));
  // All weak: nothing is observable, and no figure stands in for it.
  SensorModel weak = noisy_fit();
  weak.taxels[0].noise = 0.06;
  const Evaluation none = evaluate(known_loop(), weak);
  CHECK(none.flat_share == 1.0);
  CHECK(std::isnan(none.comp_distance_observable));
  CHECK(std::isnan(none.mean_error_observable_psi));
  CHECK(none.levels[2].comp_distance_observable == 0.0);
}

TEST_CASE("the mean taxel's trace by hand: measured, by the model, and compensated") {
  const Evaluation e = evaluate(known_loop(), straight_fit());
  REQUIRE(e.traces.size() == 1);
  const Trace& trace = e.traces.front();
  CHECK(trace.sequence == "loop");
  check_values(trace.pressure_psi, {0, 20, 41, 60, 40, 20, 0});
  check_values(trace.measured_v, {0, 1.5, 3.075, 4.5, 3.125, 1.7, 0});
  check_values(trace.model_v, {0, 1.5, 3.075, 4.5, 3.0, 1.5, 0});  // 4.5 V of 60 psi, without hysteresis
  check_values(trace.compensated_psi, {0, 20, 41, 60, 41, 23.5, 0});
}

TEST_CASE("models made before, by hand: without the taxels that the run omits") {
  const Dataset data = known_loop();
  const SensorModel fit = straight_fit();
  SensorModel before = fit;
  before.taxels[2] = straight_taxel(10.0);  // fitted then, dead now
  const AsFound found = as_found_with(data, fit, before, "earlier");
  CHECK(found.fitted_taxels == 2);
  CHECK(found.evaluation.mean_error_psi == Approx(11.0 / 14.0));
}

TEST_CASE("errors of the sweeps and the zero's return by hand") {
  Dataset data = known_loop();
  data.sequences[0].repeats[0].volts[6 * 3] = 0.004;  // ends 4 mV up, the second repeat 7 mV down
  data.sequences[0].repeats[1].volts[6 * 3] = -0.007;
  const SweepErrors errors = sweep_errors(data, straight_fit());
  CHECK(errors.repeats_with_zero == 2);
  check_values({errors.zero_return_v[0], errors.zero_return_v[1]}, {-0.0015, 0.0});
  check_values({errors.zero_return_s_v[0], errors.zero_return_s_v[1]}, {0.011 / std::sqrt(2.0), 0.0});
  CHECK(errors.groups == 2);
  REQUIRE(errors.levels.size() == 8);
  const LevelReadings& down = errors.levels[5];
  CHECK_FALSE(down.up);
  CHECK(down.pressure_psi == 20.0);
  REQUIRE(down.readings == 2);
  check_values({down.error_psi[0], down.error_psi[1], down.error_psi[3], down.error_psi[4]}, {5, 1, 7, 1});
  CHECK(std::isnan(down.error_psi[2]));
}
