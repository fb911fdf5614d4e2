// The congruency test, folds and validity by hand.
#include "analysis/identify/congruency.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/identify/folds.h"
#include "analysis/identify/sensor_model.h"
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

TEST_CASE("congruency by hand: inner branches between the same inputs rise and fall alike but for the divider") {
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

TEST_CASE("congruency by hand: the misfit is the root mean square of what rise and fall differ by, at three pairs") {
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

TEST_CASE(
    "congruency by hand: branches count that come from the ends, within a hundredth, and reach the other's turn") {
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

TEST_CASE("linearised by hand: histories and both patterns go through the divider") {
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

TEST_CASE("folds by hand: inner branches in turn, those that begin within a hundredth of the ends in none") {
  const std::vector<double> x{0, 10, 4, 9.9375, 0.0625, 6, 2, 10, 0.125, 9.875, 0};
  const FitData data = straight_loop({along("a", x, x)});
  // Inner ones: up from 4, down from 6, up from 2, up from 0.125, down from 9.875.
  const std::vector<int> inner{2, 5, 6, 8, 9};
  for (const int most : {5, 2}) {
    const std::vector<Fold> folds = folds_of(data, most);
    REQUIRE(folds.size() == static_cast<std::size_t>(most));
    for (std::size_t f = 0; f < folds.size(); ++f) {
      std::vector<int> held, by_hand;
      for (const Branch& branch : folds[f].held[0]) held.push_back(branch.first);
      for (std::size_t k = 0; k < inner.size(); ++k)
        if (k % static_cast<std::size_t>(most) == f) by_hand.push_back(inner[k]);
      CHECK(held == by_hand);
      CHECK(folds[f].kept[0].size() == 10 - by_hand.size());
    }
  }
  CHECK(folds_of(straight_loop({along("a", {0, 10, 4, 10, 0}, {0, 10, 4, 10, 0})})).empty());
  CHECK(folds_of(straight_loop({along("a", {0, 10, 4, 10, 4, 10}, {0, 10, 4, 10, 4, 10})})).size() == 2);
  CHECK(with_branches(data, {{{2, 3, true}}}).histories[0].branches.size() == 1);
}

TEST_CASE("validity by hand: what was seen, with a fiftieth of the input, a tenth of the times, and a degree around") {
  History seen_by_fit{"a", {0, 10, 4}, {0, 1, 0.5}, {}, {0.0, 2.0, 6.0}, {9.0, 1.0, 3.0}};
  SensorModel model;
  model.validity = validity_of({seen_by_fit}, {20.0, 22.0});
  const Validity& box = model.validity;
  CHECK((box.input->low == 0.0 && box.input->high == 10.0));
  CHECK((box.hold_s->low == 1.0 && box.hold_s->high == 3.0));  // not of the first sample
  CHECK((box.rate->low == 1.5 && box.rate->high == 5.0));
  CHECK((box.temperature_c->low == 20.0 && box.temperature_c->high == 22.0));
  CHECK(box.input->contains(10.5, 0.5));
  CHECK(box.input->contains(-0.5, 0.5));
  CHECK_FALSE(box.input->contains(10.5625, 0.5));
  CHECK_FALSE(box.input->contains(-0.5625, 0.5));
  CHECK(box.input->contains(10.0));
  const auto outside = [&](const History& history, const std::vector<double>& celsius) {
    Histories used;
    TaxelHistories taxel;
    taxel.score = {history};
    used.taxels = {taxel};
    used.temperatures_c = celsius;
    used.input_unit = "kPa";
    std::string text;
    for (const std::string& line : outside_validity(model, used)) text += line + "; ";
    return text;
  };
  const auto inputs = [&](double low, double high) { return outside({"a", {low, high}, {0, 1}, {}, {}, {}}, {}); };
  CHECK(inputs(-0.19, 10.19).empty());
  CHECK(inputs(-0.21, 5.0) == "input -0.21 to 5 kPa (fitted at 0 to 10); ");
  CHECK(inputs(5.0, 10.21) == "input 5 to 10.21 kPa (fitted at 0 to 10); ");
  const auto times = [&](double hold, double seconds) {
    return outside({"a", {0, 5}, {0, 1}, {}, {0.0, seconds}, {0.0, hold}}, {});
  };
  CHECK(times(0.91, 2.0).empty());
  CHECK(times(3.29, 2.0).empty());
  CHECK(times(0.89, 2.0) == "hold 0.89 s (fitted at 1 to 3); ");
  CHECK(times(3.31, 2.0) == "hold 3.31 s (fitted at 1 to 3); ");
  CHECK(times(2.0, 5.0 / 5.45).empty());
  CHECK(times(2.0, 5.0 / 5.55) == "rate 5.55 kPa/s (fitted at 1.5 to 5); ");
  CHECK(times(2.0, 1000.0).empty());
  CHECK(times(2.0, 0.0).empty());
  const auto degrees = [&](double celsius) { return outside({"a", {0, 5}, {0, 1}, {}, {}, {}}, {celsius}); };
  CHECK(degrees(19.0).empty());
  CHECK(degrees(23.0).empty());
  CHECK(degrees(18.9) == "temperature 18.9 degC (fitted at 20 to 22); ");
  CHECK(degrees(23.1) == "temperature 23.1 degC (fitted at 20 to 22); ");
}
