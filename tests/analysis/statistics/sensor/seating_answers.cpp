// The parts of the seating check by hand: how well a pattern fits in each position, and the lines at each limit.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/statistics/sensor/seating.h"

using namespace tactbench::analysis;

namespace {

double fit_in(const std::vector<SeatingPosition>& fits, const std::string& name) {
  for (const SeatingPosition& fit : fits)
    if (fit.name == name) return fit.correlation;
  FAIL_CHECK("no position " << name);
  return 0.0;
}

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
    CHECK(fits[0].name == "as before");
    CHECK(fits[0].correlation == Approx(own.correlation).margin(1e-9));
    CHECK(fit_in(fits, "mirrored, first row with last") == Approx(own.correlation).margin(1e-9));  // there is one row
  }
}

TEST_CASE("seating by hand: each of the eight positions fits the pattern that was moved so, and no other") {
  // 1 to 9 by rows, then where each of them lies after the sensor was moved.
  const std::vector<double> before{1, 2, 3, 4, 5, 6, 7, 8, 10};
  const std::vector<std::pair<std::string, std::vector<double>>> moved = {
      {"as before", {1, 2, 3, 4, 5, 6, 7, 8, 10}},
      {"turned by 180 degrees", {10, 8, 7, 6, 5, 4, 3, 2, 1}},
      {"mirrored, first row with last", {7, 8, 10, 4, 5, 6, 1, 2, 3}},
      {"mirrored, first column with last", {3, 2, 1, 6, 5, 4, 10, 8, 7}},
      {"turned clockwise by 90 degrees", {7, 4, 1, 8, 5, 2, 10, 6, 3}},
      {"turned counter-clockwise by 90 degrees", {3, 6, 10, 2, 5, 8, 1, 4, 7}},
      {"mirrored, rows with columns", {1, 4, 7, 2, 5, 8, 3, 6, 10}},
      {"mirrored, rows with columns from the far corner", {10, 6, 3, 8, 5, 2, 7, 4, 1}}};
  const std::vector<bool> all(9, true);
  for (const auto& [name, now] : moved) {
    INFO(name);
    const auto fits = compare_positions(3, 3, now, before, all, all);
    REQUIRE(fits.size() == 8);
    for (const SeatingPosition& fit : fits) {
      INFO(fit.name);
      CHECK((fit.name == name ? fit.correlation == Approx(1.0) : fit.correlation < 0.99));
    }
  }
}

TEST_CASE("seating by hand: a taxel counts where it answered in both seatings, at its place in either") {
  // Turned by 180 degrees: what lay first lies last. The last of now and the first of before are one taxel.
  const std::vector<double> before{9, 1, 2, 3, 4, 5}, now{5, 4, 3, 2, 1, -9};
  std::vector<bool> all(6, true), not_first = all, not_last = all;
  not_first[0] = false;
  not_last[5] = false;
  const char* turned = "turned by 180 degrees";
  CHECK(fit_in(compare_positions(2, 3, now, before, all, all), turned) < 0.5);
  CHECK(fit_in(compare_positions(2, 3, now, before, not_last, all), turned) == Approx(1.0));
  CHECK(fit_in(compare_positions(2, 3, now, before, all, not_first), turned) == Approx(1.0));
  CHECK(fit_in(compare_positions(2, 3, now, before, not_first, all), turned) < 0.5);
  // Three taxels are the fewest that say something.
  const std::vector<bool> three{true, true, true, false, false, false}, two{true, true, false, false, false, false};
  CHECK(fit_in(compare_positions(1, 6, before, before, three, all), "as before") == Approx(1.0));
  CHECK(fit_in(compare_positions(1, 6, before, before, two, all), "as before") == 0.0);
}
