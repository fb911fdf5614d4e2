// Every figure of the levels of a loop by hand: two taxels that count, one that does not, readings of which some are
// flat.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/streams.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

TaxelTable up_and_down(std::vector<double> values) {
  return {{0, 30, 60, 30, 0}, std::move(values), {{0, 2, true}, {2, 4, false}}};
}

// Up over three levels and down; of each step the first taxel, the second and the dead one.
CompensatedStreams three_levels() {
  CompensatedSequence own;
  own.raw = up_and_down({0, 0, 9, 1, 2, 9, 3, 5, 9, 2, 3, 9, 0.5, 0.1, 9});
  own.pressure = up_and_down({0, 0, 7, 30, 30, 7, 60, 60, 7, 33, 30.6, 7, 0, 1.2, 7});
  own.flat = up_and_down({0, 0, 0, 0, 0, 0, 0.5, 0, 0, 0.4, 0, 0, 1, 0, 0});
  own.reference_psi = {0.1, 30.2, 60.3, 29.8, 0.2};
  return {{own}, {}};
}

}  // namespace

TEST_CASE("levels by hand: distances, spreads and flat taxels of each level, means over levels, the worst taxels") {
  Evaluation e;
  gather_levels(e, three_levels(), Fitted(straight_fit()));
  CHECK(e.full_scale_psi == 60.0);
  CHECK(e.full_scale_v == 4.0);  // of 3 and 5 V
  REQUIRE(e.levels.size() == 3);
  const LevelFigures &low = e.levels[0], &middle = e.levels[1], &high = e.levels[2];
  CHECK((low.pressure_psi == 0.0 && low.up_psi == 0.1 && low.down_psi == 0.2));
  CHECK((middle.pressure_psi == 30.0 && middle.up_psi == 30.2 && middle.down_psi == 29.8));
  check_alike(middle.raw_up_v, {1, 2, 9}, 1e-12);
  check_alike(middle.raw_down_v, {2, 3, 9}, 1e-12);
  check_alike(middle.comp_up_psi, {30, 30, kNan}, 1e-12);
  check_alike(middle.comp_down_psi, {33, 30.6, kNan}, 1e-12);
  // Of two values the standard deviation is their difference over the root of 2.
  CHECK(middle.raw_std_up == Approx(1.0 / std::sqrt(2.0) / 4.0));
  CHECK(low.raw_std_down == Approx(0.4 / std::sqrt(2.0) / 4.0));
  CHECK(middle.comp_std_up == Approx(0.0).margin(1e-12));
  CHECK(middle.comp_std_down == Approx(2.4 / std::sqrt(2.0) / 60.0));
  CHECK(middle.raw_mean_distance == Approx(1.0 / 4.0));
  CHECK(low.raw_mean_distance == Approx(0.3 / 4.0));
  CHECK(middle.comp_mean_distance == Approx(1.8 / 60.0));
  CHECK(middle.raw_distance == Approx(1.0 / 4.0));
  CHECK(middle.comp_distance == Approx(1.8 / 60.0));
  CHECK(low.comp_distance == Approx(0.6 / 60.0));
  CHECK(middle.worst_taxel_distance == Approx(3.0 / 60.0));
  CHECK(low.worst_taxel_distance == Approx(1.2 / 60.0));
  // Going down the first taxel is flat at 0 psi, and at 60, where half of the sweeps are.
  CHECK((low.flat_taxels == 1 && middle.flat_taxels == 0 && high.flat_taxels == 1));
  CHECK(low.comp_distance_observable == Approx(1.2 / 60.0));
  CHECK(middle.comp_distance_observable == Approx(1.8 / 60.0));
  CHECK(middle.worst_taxel_distance_observable == Approx(3.0 / 60.0));
  CHECK_FALSE((low.made_worse || middle.made_worse || high.made_worse));
  // Over the levels.
  CHECK(e.hysteresis_max_fs == Approx(1.0 / 4.0));
  CHECK(e.hysteresis_mean_fs == Approx(1.3 / 12.0));
  CHECK(e.raw_distance == Approx(1.3 / 12.0));
  CHECK(e.comp_distance_of_mean == Approx(2.4 / 180.0));
  CHECK(e.comp_distance == Approx(2.4 / 180.0));
  CHECK(e.flat_share == Approx(2.0 / 6.0));
  // The first taxel's 3 psi at one of three levels, the only one where it is not flat.
  CHECK(e.worst_taxel_distance == Approx(3.0 / 180.0));
  CHECK(e.worst_taxel_distance_observable == Approx(3.0 / 60.0));
  CHECK(e.comp_distance_observable == Approx((3.0 + 1.2 + 0.6) / 60.0 / 4.0));
}

TEST_CASE("levels by hand: where all taxels are flat no distance is observed, and compensation may be worse") {
  CompensatedStreams streams = three_levels();
  streams.sequences[0].flat.values.assign(15, 1.0);
  streams.sequences[0].pressure.values[9] = 50.0;  // 20 psi against a quarter of full scale
  streams.sequences[0].pressure.values[10] = 45.0;
  Evaluation e;
  gather_levels(e, streams, Fitted(straight_fit()));
  CHECK(std::isnan(e.comp_distance_observable));
  CHECK(e.worst_taxel_distance_observable == 0.0);
  CHECK(e.flat_share == 1.0);
  CHECK(e.levels[1].comp_distance == Approx(17.5 / 60.0));
  CHECK(e.levels[1].made_worse);
  CHECK(e.levels[1].comp_distance_observable == 0.0);
  // Of one taxel at one level all that is observed is its distance.
  streams.sequences[0].flat.values[9] = 0.0;
  Evaluation one;
  gather_levels(one, streams, Fitted(straight_fit()));
  CHECK(one.comp_distance_observable == Approx(20.0 / 60.0));
  CHECK(one.worst_taxel_distance_observable == Approx(20.0 / 60.0));
  CHECK(one.flat_share == Approx(5.0 / 6.0));
}

TEST_CASE("levels by hand: of one taxel there is no spread over the taxels") {
  SensorModel fit = straight_fit();
  fit.taxels[1].status = TaxelStatus::kDead;
  Evaluation e;
  gather_levels(e, three_levels(), Fitted(fit));
  CHECK(e.full_scale_v == 3.0);
  for (const LevelFigures& level : e.levels) {
    CHECK((level.raw_std_up == 0.0 && level.raw_std_down == 0.0));
    CHECK((level.comp_std_up == 0.0 && level.comp_std_down == 0.0));
  }
  CHECK(e.levels[1].comp_distance == Approx(3.0 / 60.0));
}
