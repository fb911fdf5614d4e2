// The congruency test by hand.
#include "analysis/identify/congruency.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

namespace {

History along(const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
  return {name, x, y, branches_along(x), {}, {}};
}

// 0 to `top` over 0 to 10, straight.
FitData straight_loop(std::vector<History> histories, double top = 10.0, double zero = 0.0) {
  const std::vector<double> x{0, 10}, y{zero, top};
  return {std::move(histories), PatternCurve(x, y, zero, top), PatternCurve(x, y, zero, top)};
}

// Outputs of inner branches of a film u, seen through a divider of amplitude 4 above a zero of 0.5.
double seen(double u) { return 0.5 + u / (1.0 + u / 4.0); }

// Rises from `turn` and falls from `turn` of a film whose inner branches are straight, 0.5 a unit steep.
FitData congruent(bool divided) {
  const auto out = [&](double u) { return divided ? seen(u) : 0.5 + u; };
  std::vector<History> histories;
  for (const double turn : {2.0, 4.0}) {
    // From the top, u = 10, down to the turn at u = turn + 1 and up again, so that the rise has 0.5 a unit.
    std::vector<double> x{10.0, turn}, y{out(10.0), out(turn + 1.0)};
    for (const double at : {6.0, 8.0}) {
      x.push_back(at);
      y.push_back(out(turn + 1.0 + 0.5 * (at - turn)));
    }
    histories.push_back(along("up", x, y));
  }
  for (const double turn : {6.0, 8.0}) {
    std::vector<double> x{0.0, turn}, y{out(0.0), out(0.8 * turn)};
    for (const double at : {4.0, 2.0}) {
      x.push_back(at);
      y.push_back(out(0.8 * turn - 0.5 * (turn - at)));
    }
    histories.push_back(along("down", x, y));
  }
  return straight_loop(std::move(histories), out(10.0), out(0.0));
}

Congruency of_rises(const std::vector<std::pair<double, double>>& rises, double fall_turn = 7.0) {
  // From 0 to a turn at 7 and down to 0, straight, 1 a unit; from 10 down to a turn, straight, and up to 10 so steep
  // that the output at 7 is as given.
  std::vector<History> histories = {along("fall", {0, fall_turn, 0}, {0, fall_turn, 0})};
  for (const auto& [turn, slope] : rises)
    histories.push_back(along("rise", {10, turn, 10}, {10, turn, turn + slope * (10.0 - turn)}));
  return find_divider(straight_loop(histories));
}

}  // namespace

TEST_CASE("congruency: finds the divider for which inner branches between equal inputs rise and fall equally") {
  const Congruency found = find_divider(congruent(true));
  CHECK(found.pairs == 4);
  CHECK(found.divider.zero == 0.5);
  CHECK(found.divider.per_amplitude == Approx(0.25).epsilon(1e-6));
  CHECK(found.rms == Approx(0.0).margin(1e-7));
  CHECK(found.plain_rms > 0.01);
  const Congruency none = find_divider(congruent(false));
  CHECK(none.pairs == 4);
  CHECK(none.divider.per_amplitude == 0.0);
  CHECK(none.divider.zero == 0.5);
  CHECK(none.rms == none.plain_rms);
  CHECK(none.plain_rms == Approx(0.0).margin(1e-12));
}

TEST_CASE("congruency: the misfit is the RMS difference of rises and falls, and needs three pairs") {
  // Between 4 and 7 the fall is 3, between 1 and 7 6, between 3 and 7 4: rises that are 1, 2 and 2 more.
  const Congruency found = of_rises({{4.0, 4.0 / 3.0}, {1.0, 8.0 / 6.0}, {3.0, 6.0 / 4.0}});
  CHECK(found.pairs == 3);
  CHECK(found.plain_rms == Approx(std::sqrt(9.0 / 3.0)));
  // Two pairs are too few, and so are turns that do not lie below the fall's.
  const Congruency few = of_rises({{4.0, 2.0}, {1.0, 2.0}, {7.0, 2.0}, {8.0, 2.0}});
  CHECK(few.pairs == 2);
  CHECK(few.plain_rms == 0.0);
  CHECK(few.divider.per_amplitude == 0.0);
  // Turns within a hundredth of the ends are none inside.
  CHECK(of_rises({{0.1, 1.5}, {1.0, 1.5}, {3.0, 1.5}}).pairs == 2);
  CHECK(of_rises({{0.125, 1.5}, {1.0, 1.5}, {3.0, 1.5}}).pairs == 3);
  CHECK(of_rises({{1.0, 1.5}, {2.0, 1.5}, {3.0, 1.5}}, 9.9375).pairs == 0);
  CHECK(of_rises({{1.0, 1.5}, {2.0, 1.5}, {3.0, 1.5}}, 9.875).pairs == 3);
}

TEST_CASE("congruency: only branches from within 1 % of an end that reach the other's turning point count") {
  const auto pairs = [](const History& rise) {
    std::vector<History> histories = {along("fall", {0, 7, 0}, {0, 7, 0})};
    for (int n = 0; n < 3; ++n) histories.push_back(rise);
    return find_divider(straight_loop(histories)).pairs;
  };
  CHECK(pairs(along("rise", {10, 4, 10}, {10, 4, 10})) == 3);
  CHECK(pairs(along("rise", {9.9375, 4, 10}, {10, 4, 10})) == 3);
  CHECK(pairs(along("rise", {9.875, 4, 10}, {10, 4, 10})) == 0);
  CHECK(pairs(along("rise", {10, 4, 7}, {10, 4, 7})) == 3);
  CHECK(pairs(along("rise", {10, 4, 6.9375}, {10, 4, 7})) == 0);
  // A fall that follows a fall has no turn between.
  History none = along("rise", {10, 4, 10}, {10, 4, 10});
  none.branches[0].ascending = true;
  CHECK(pairs(none) == 0);
}

TEST_CASE("linearised: histories and both patterns are converted by the divider") {
  const Divider divider{0.5, 0.25};
  FitData data = straight_loop({along("a", {0, 10}, {0.5, seen(3.0)})}, seen(10.0), 0.5);
  data.descending =
      PatternCurve(std::vector<double>{0, 5, 10}, std::vector<double>{0.5, seen(8.0), seen(10.0)}, 0.5, seen(10.0));
  const FitData own = linearised(data, divider);
  CHECK(own.histories[0].y[0] == Approx(0.0).margin(1e-12));
  CHECK(own.histories[0].y[1] == Approx(3.0));
  CHECK(own.ascending.y()[1] == Approx(10.0));
  CHECK(own.descending.y()[1] == Approx(8.0));
  CHECK(own.descending.x()[1] == 5.0);
}
