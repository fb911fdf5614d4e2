// Chamber and sensor kept apart, on arrays of two by two whose every figure can be had on paper.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/alike.h"

using namespace tactbench::analysis;

namespace {

using Maps = std::vector<std::vector<double>>;
using Places = std::vector<std::vector<int>>;

const std::vector<int> kAsItLay{0, 1, 2, 3}, kHalfTurned{3, 2, 1, 0};
// The first and the last taxel change places, and the two between. First pair: the sensor's part 2 and 7 (means of its
// own two readings), the cells' 3 and 6, so -1.5 and +1.5 about their mean; what is left is +-0.5 in all four. Second
// pair: 2.5 and 4.5, the cells alike, +-0.5 left again.
const Maps kTwoRuns{{1, 2, 4, 9}, {3, 3, 5, 5}};

void check_map(const std::vector<double>& found, const std::vector<double>& expected) {
  check_alike(found, expected, 1e-12);
}

// Estimates of one sweep: at each level the level itself and `factor` times the run's row.
SweepEstimates turned_estimates(const std::vector<double>& levels, const std::vector<double>& factors,
                                const std::vector<double>& row) {
  SweepEstimates out;
  out.pressure_psi = levels;
  out.sweeps = 1;
  out.taxels = static_cast<int>(row.size());
  for (std::size_t level = 0; level < levels.size(); ++level)
    for (const double own : row) out.psi.push_back(levels[level] + factors[level] * own);
  return out;
}

// Half turn of the two runs: as they are at 10 psi times 0.1, at 20 psi times 0.4, and at the models' end.
std::vector<TurnedRun> half_turn(const std::vector<double>& second_levels = {0, 10, 20, 60}) {
  const std::vector<double> factors{0.0, 0.1, 0.4, 0.0};
  return {{11, 0, turned_estimates({0, 10, 20, 60}, factors, kTwoRuns[0])},
          {12, 180, turned_estimates(second_levels, factors, kTwoRuns[1])}};
}

}  // namespace

TEST_CASE("rotated places: each taxel of square and rectangular arrays has the expected place") {
  CHECK(turned_places(2, 2, 0) == kAsItLay);
  CHECK(turned_places(2, 2, 90) == std::vector<int>{2, 0, 3, 1});
  CHECK(turned_places(2, 2, 180) == kHalfTurned);
  CHECK(turned_places(2, 2, 270) == std::vector<int>{1, 3, 0, 2});
  CHECK(turned_places(3, 3, 90) == std::vector<int>{6, 3, 0, 7, 4, 1, 8, 5, 2});
  CHECK(turned_places(3, 3, 270) == std::vector<int>{2, 5, 8, 1, 4, 7, 0, 3, 6});
  CHECK(turned_places(2, 3, 0) == std::vector<int>{0, 1, 2, 3, 4, 5});
  CHECK(turned_places(3, 2, 180) == std::vector<int>{5, 4, 3, 2, 1, 0});
  for (const int angle : {-90, 1, 360}) CHECK_THROWS_AS(turned_places(2, 2, angle), std::invalid_argument);
  CHECK_THROWS_AS(turned_places(3, 2, 270), std::invalid_argument);
}

TEST_CASE(
    "uniformity maps: of two half-turned runs, with residual and degrees of freedom, match hand-computed values") {
  const TurnedMaps maps = separate_maps(kTwoRuns, Places{kAsItLay, kHalfTurned});
  check_map(maps.sensor, {2, 2.5, 4.5, 7});
  check_map(maps.chamber, {-1.5, 0, 0, 1.5});
  CHECK(maps.undetermined == 2);
  CHECK(maps.degrees == 2.0);           // eight equations, four taxels, four cells, two free constants
  CHECK(maps.residual == Approx(1.0));  // eight times 0.25
}

TEST_CASE("uniformity maps: one missing reading makes its set exact, two leave the chamber unknown there") {
  Maps one = kTwoRuns;
  one[1][3] = kNan;  // 1 = s + c, 9 = s' + c', 3 = s + c' with c' = -c: c = -1, s = 2, s' = 8
  const TurnedMaps three = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(three.sensor, {2, 2.5, 4.5, 8});
  check_map(three.chamber, {-1, 0, 0, 1});
  CHECK(three.undetermined == 2);
  CHECK(three.degrees == 1.0);
  CHECK(three.residual == Approx(1.0));  // the second pair's 4 x 0.25
  one[1][0] = kNan;
  const TurnedMaps apart = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(apart.sensor, {1, 2.5, 4.5, 9});
  check_map(apart.chamber, {kNan, 0, 0, kNan});
  CHECK(apart.undetermined == 3);
  CHECK(apart.degrees == 1.0);
  one[0][3] = kNan;
  const TurnedMaps none = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(none.sensor, {1, 2.5, 4.5, kNan});
  check_map(none.chamber, {kNan, 0, 0, kNan});
  CHECK(none.undetermined == 2);
}

TEST_CASE("uniformity maps: runs at the same angle give no chamber map, and a single run no residual") {
  const TurnedMaps alike = separate_maps(Maps{{1, 3}, {2, 5}}, Places{{0, 1}, {0, 1}});
  check_map(alike.sensor, {1.5, 4});
  check_map(alike.chamber, {kNan, kNan});
  CHECK(alike.undetermined == 2);
  CHECK(alike.degrees == 2.0);
  CHECK(alike.residual == Approx(std::sqrt(2.5 / 2.0)));  // 2 x 0.25 and 2 x 1
  const TurnedMaps single = separate_maps(Maps{{1, 3}}, Places{{0, 1}});
  check_map(single.sensor, {1, 3});
  CHECK(single.degrees == 0.0);
  CHECK(std::isnan(single.residual));
  const TurnedMaps empty = separate_maps({}, {});
  CHECK((empty.sensor.empty() && empty.undetermined == 0 && std::isnan(empty.residual)));
}

TEST_CASE("uniformity: spread, residual, slopes and constant parts of the levels match hand-computed values") {
  const Uniformity u = uniformity_of(half_turn(), 2, 2);
  REQUIRE(u.assessed());
  CHECK(u.runs == std::vector<std::int64_t>{11, 12});
  CHECK(u.angles_deg == std::vector<int>{0, 180});
  CHECK(u.pressure_psi == std::vector<double>{10, 20});
  // The chamber's -1.5, 0, 0, 1.5 has a standard deviation of sqrt(4.5 / 3). The rest's sum of squares is 2; of the two
  // degrees of freedom the second run's own constant takes one.
  const double spread = std::sqrt(1.5), rest = std::sqrt(2.0);
  check_map(u.u_psi, {0.1 * spread, 0.4 * spread});
  check_map(u.residual_psi, {0.1 * rest, 0.4 * rest});
  CHECK(u.residual_rms_psi == Approx(std::sqrt((0.02 + 0.32) / 2)));
  CHECK(u.residual_other_sense_psi == Approx(u.residual_rms_psi));  // a half turn has no sense
  // 0.1 at 10 and 0.4 at 20 psi: 0.03 a psi from -0.2 on.
  check_map(u.chamber_share, {-0.045, 0, 0, 0.045});
  check_map(u.chamber_psi, {0.3, 0, 0, -0.3});
  check_map(u.sensor_share, {-0.06, -0.045, 0.015, 0.09});  // less the mean of 4
  CHECK(u.u_share == Approx(0.03 * spread));
  CHECK(u.u_offset_psi == Approx(0.2 * spread));
  CHECK(u.undetermined == 2);
  CHECK(u.degrees == 2.0);
}

TEST_CASE("uniformity: several sweeps count by their mean, and a run's own constant enters no map") {
  std::vector<TurnedRun> runs = half_turn();
  for (TurnedRun& run : runs) {  // two sweeps, 0.25 psi to either side, the second run 3 psi higher
    const std::vector<double> one = run.estimates.psi;
    run.estimates.sweeps = 2;
    run.estimates.psi.clear();
    for (std::size_t level = 0; level < 4; ++level)
      for (const double side : {-0.25, 0.25})
        for (std::size_t taxel = 0; taxel < 4; ++taxel)
          run.estimates.psi.push_back(one[level * 4 + taxel] + side + (run.run == 12 ? 3.0 : 0.0));
  }
  const Uniformity u = uniformity_of(runs, 2, 2);
  check_map(u.chamber_share, {-0.045, 0, 0, 0.045});
  check_map(u.sensor_share, {-0.06, -0.045, 0.015, 0.09});
  CHECK(u.residual_psi[0] == Approx(0.1 * std::sqrt(2.0)));
}

TEST_CASE("uniformity: the residual for the opposite sense of rotation is that of the negated angles") {
  const auto quarter = [](int angle) {
    return std::vector<TurnedRun>{{1, 0, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {1, 2, 4, 9})},
                                  {2, angle, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {3, 8, 5, 5})},
                                  {3, 180, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {2, 1, 7, 3})}};
  };
  const Uniformity left = uniformity_of(quarter(90), 2, 2), right = uniformity_of(quarter(270), 2, 2);
  REQUIRE((left.assessed() && right.assessed()));
  CHECK(left.residual_rms_psi != Approx(right.residual_rms_psi));
  CHECK(left.residual_other_sense_psi == Approx(right.residual_rms_psi));
  CHECK(right.residual_other_sense_psi == Approx(left.residual_rms_psi));
}

TEST_CASE("uniformity: levels match within 0.05 psi and count above 0.5 psi, and two are needed") {
  CHECK(uniformity_of(half_turn({0, 10.04, 20, 60}), 2, 2).pressure_psi == std::vector<double>{10, 20});
  const Uniformity other = uniformity_of(half_turn({0, 10.06, 20, 60}), 2, 2);
  CHECK_FALSE(other.assessed());
  CHECK(other.pressure_psi == std::vector<double>{20});
  CHECK(other.u_psi.empty());
  const auto lowest = [](double level) {
    return std::vector<TurnedRun>{{1, 0, turned_estimates({level, 10, 20, 60}, {0, 0.1, 0.4, 0}, kTwoRuns[0])},
                                  {2, 180, turned_estimates({level, 10, 20, 60}, {0, 0.1, 0.4, 0}, kTwoRuns[1])}};
  };
  CHECK(uniformity_of(lowest(0.5), 2, 2).pressure_psi.size() == 2);
  CHECK(uniformity_of(lowest(0.51), 2, 2).pressure_psi.size() == 3);
}

TEST_CASE("uniformity: a level is dropped if over 5 % of a run's taxels are within 0.3 psi of the range's end") {
  // Twenty taxels: one of them is 5 %. 20 psi, and 50 psi where some read `psi`, in the second run alone.
  const auto near_the_end = [](int taxels, double psi) {
    std::vector<double> plain(20);
    for (std::size_t i = 0; i < 20; ++i) plain[i] = i % 3 == 0 ? 1.0 : -1.0;
    std::vector<TurnedRun> runs{{1, 0, turned_estimates({10, 20, 50, 60}, {0.1, 0.1, 0.1, 0}, plain)},
                                {2, 180, turned_estimates({10, 20, 50, 60}, {0.1, 0.1, 0.1, 0}, plain)}};
    for (int taxel = 0; taxel < taxels; ++taxel) runs[1].estimates.psi[static_cast<std::size_t>(40 + taxel)] = psi;
    return uniformity_of(runs, 4, 5).pressure_psi.size();
  };
  CHECK(near_the_end(1, 59.9) == 3);
  CHECK(near_the_end(2, 59.9) == 2);
  CHECK(near_the_end(2, 59.71) == 2);
  CHECK(near_the_end(2, 59.69) == 3);
}

TEST_CASE("uniformity: with one reading missing the run's constant is found, with no degree of freedom left") {
  // sensor 1, 2, -2, -1, chamber 0.5, -0.25, 0.25, -0.5, the second run 3 psi higher and without its last taxel.
  std::vector<double> first{1.5, 1.75, -1.75, -1.5}, second{1 - 0.5 + 3, 2 + 0.25 + 3, -2 - 0.25 + 3, kNan};
  const std::vector<TurnedRun> runs{{1, 0, turned_estimates({10, 20, 60}, {1, 1, 1}, first)},
                                    {2, 180, turned_estimates({10, 20, 60}, {1, 1, 1}, second)}};
  const Uniformity u = uniformity_of(runs, 2, 2);
  REQUIRE(u.assessed());
  // Seven equations, eight unknowns of which two are free, and the constant.
  CHECK(std::isnan(u.residual_psi[0]));
  CHECK(u.u_psi[0] == Approx(std::sqrt((2 * 0.25 + 2 * 0.0625) / 3)).epsilon(1e-3));
}
