// The parts of the seating check by hand: how well a pattern fits in each position, and the lines at each limit.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/statistics/sensor/seating.h"

using namespace tactbench::analysis;

namespace {

// Places of compare_positions().
constexpr std::size_t kAsBefore = 0, kBy180 = 1, kRowsMirrored = 2;

}  // namespace

TEST_CASE("seating by hand: correlations of small patterns, whatever their mean, and none where nothing differs") {
  struct Pattern {
    const char* what;
    std::vector<double> now, before;
    double correlation;
  };
  // About their means 0.02 and 0.03: (-1 0 1) with (-1 1 0), each times 0.01: 1 / 2. With (-1 2 -1): 0.
  const std::vector<Pattern> patterns = {{"half", {0.01, 0.02, 0.03}, {0.02, 0.04, 0.03}, 0.5},
                                         {"none", {0.01, 0.02, 0.03}, {0.02, 0.05, 0.02}, 0.0},
                                         {"opposite", {0.01, 0.02, 0.03}, {0.09, 0.06, 0.03}, -1.0},
                                         {"the same, twice as large", {0.01, 0.02, 0.05}, {0.02, 0.04, 0.10}, 1.0},
                                         {"far from zero", {5.01, 5.02, 5.03}, {-3.02, -3.00, -3.01}, 0.5},
                                         {"below zero", {-2.0, -1.0, 0.0, 1.0}, {-1.0, -2.0, 1.0, 0.0}, 0.6},
                                         {"all alike now", {0.5, 0.5, 0.5}, {0.25, 0.5, 1.0}, 0.0},
                                         {"all alike before", {0.25, 0.5, 1.0}, {0.5, 0.5, 0.5}, 0.0},
                                         {"two taxels say nothing", {0.01, 0.02}, {0.01, 0.02}, 0.0}};
  for (const Pattern& own : patterns) {
    INFO(own.what);
    const std::vector<bool> all(own.now.size(), true);
    const auto fits = compare_positions(1, static_cast<int>(own.now.size()), own.now, own.before, all, all);
    REQUIRE(fits.size() == 4);
    // There is one row: mirrored it is what it was.
    for (const std::size_t at : {kAsBefore, kRowsMirrored})
      CHECK(fits[at].correlation == Approx(own.correlation).margin(1e-9));
  }
}

TEST_CASE("seating by hand: each of the eight positions fits the pattern that was moved so, and no other") {
  // 1 to 9 by rows, then where each of them lies after the sensor was moved.
  const std::vector<double> before{1, 2, 3, 4, 5, 6, 7, 8, 10};
  const std::vector<std::vector<double>> moved = {before,
                                                  {10, 8, 7, 6, 5, 4, 3, 2, 1},   // half a turn
                                                  {7, 8, 10, 4, 5, 6, 1, 2, 3},   // rows mirrored
                                                  {3, 2, 1, 6, 5, 4, 10, 8, 7},   // columns mirrored
                                                  {7, 4, 1, 8, 5, 2, 10, 6, 3},   // a quarter clockwise
                                                  {3, 6, 10, 2, 5, 8, 1, 4, 7},   // and the other way
                                                  {1, 4, 7, 2, 5, 8, 3, 6, 10},   // rows are columns
                                                  {10, 6, 3, 8, 5, 2, 7, 4, 1}};  // from the other corner
  const std::vector<bool> all(9, true);
  for (std::size_t turn = 0; turn < moved.size(); ++turn) {
    const auto fits = compare_positions(3, 3, moved[turn], before, all, all);
    REQUIRE(fits.size() == 8);
    for (std::size_t at = 0; at < 8; ++at) {
      CAPTURE(turn, at);
      CHECK((at == turn ? fits[at].correlation == Approx(1.0) : fits[at].correlation < 0.99));
    }
  }
}

TEST_CASE("seating by hand: a taxel counts where it answered in both seatings, at its place in either") {
  // Turned by 180 degrees: what lay first lies last. The last of now and the first of before are one taxel.
  const std::vector<double> before{9, 1, 2, 3, 4, 5}, now{5, 4, 3, 2, 1, -9};
  std::vector<bool> all(6, true), not_first = all, not_last = all;
  not_first[0] = false;
  not_last[5] = false;
  const auto turned = [&](const std::vector<bool>& use_now, const std::vector<bool>& use_before) {
    return compare_positions(2, 3, now, before, use_now, use_before)[kBy180].correlation;
  };
  CHECK(turned(all, all) < 0.5);
  CHECK(turned(not_last, all) == Approx(1.0));
  CHECK(turned(all, not_first) == Approx(1.0));
  CHECK(turned(not_first, all) < 0.5);
  // Three taxels are the fewest that say something.
  const std::vector<bool> three{true, true, true, false, false, false}, two{true, true, false, false, false, false};
  CHECK(compare_positions(1, 6, before, before, three, all)[kAsBefore].correlation == Approx(1.0));
  CHECK(compare_positions(1, 6, before, before, two, all)[kAsBefore].correlation == 0.0);
}
