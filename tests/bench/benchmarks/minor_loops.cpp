// `benchmark specimen`: minor loops whose heights are equal behind one divider, for each divider that is tried.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "bench/benchmarks/specimen.h"

using namespace tactbench::bench;

namespace {

constexpr double kNoDivider = std::numeric_limits<double>::infinity();

// Through a divider: the volts of a conductance in units of its reference.
double divided(double u, double amplitude) { return std::isinf(amplitude) ? u : amplitude * u / (amplitude + u); }

// Heights of 0.5 and 1, each from two places that lie apart; `more`: of the first one from above.
std::vector<MinorLoop> loops_behind(double amplitude, double more = 0.0) {
  const auto volts = [&](double u) { return divided(u, amplitude); };
  return {{volts(1.0), volts(1.5), volts(2.0), volts(2.5 + more)}, {volts(0.5), volts(1.5), volts(2.75), volts(3.75)}};
}

double difference_behind(double amplitude, double more = 0.0) {
  return height_difference(loops_behind(amplitude, more), divided(0.25, amplitude), divided(4.25, amplitude));
}

}  // namespace

TEST_CASE("specimen figures: loops that are congruent behind one of the dividers, and behind none of them") {
  for (const double amplitude : {kNoDivider, 40.0, 20.0, 12.0, 9.0, 7.5, 6.5, 6.0, 5.5}) {
    INFO("divider of " << amplitude << " V");
    CHECK(difference_behind(amplitude) < 1e-12);
    // A sixteenth of the span, of one of two loops.
    CHECK(difference_behind(amplitude, 0.25) <= Approx(0.25 / 4.0 / std::sqrt(2.0)));
    CHECK(difference_behind(amplitude, 0.25) > 0.01);
  }
  CHECK(difference_behind(kNoDivider, -0.25) <= Approx(0.25 / 4.0 / std::sqrt(2.0)));
  for (const double amplitude : {80.0, 28.0, 15.0, 10.3, 8.2, 7.0, 6.25, 5.75, 5.0}) {
    INFO("divider of " << amplitude << " V");
    CHECK(difference_behind(amplitude) > 1e-5);
  }
}

TEST_CASE("specimen figures: a divider has to lie 2 % above the highest output") {
  // Congruent behind the divider of 5.5 V alone, for a top of 5.5 / 1.02 V, just below it and just above it.
  const std::vector<MinorLoop> loops = loops_behind(5.5);
  CHECK(height_difference(loops, divided(0.25, 5.5), 5.5 / 1.02 - 1e-6) < 1e-12);
  CHECK(height_difference(loops, divided(0.25, 5.5), 5.5 / 1.02 + 1e-6) > 1e-6);
  // Without a divider every top will do.
  CHECK(height_difference(loops_behind(kNoDivider), 0.0, 50.0) < 1e-12);
  CHECK(height_difference(loops_behind(kNoDivider, 4.0), 0.0, 50.0) == Approx(4.0 / 50.0 / std::sqrt(2.0)));
}
