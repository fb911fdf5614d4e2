// The fast compensator's curves at their bounds: what is saturated, which turns are at an end of the range, exact ends.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/compensate/composed_curve.h"

using namespace tactbench::analysis;

namespace {

// 0 to 100 psi are 3 units of output: up by 1 at 50 psi, down by 2.5.
TaxelPattern bent_pattern(double alpha_d) {
  TaxelPattern p;
  p.x = {0.0, 50.0, 100.0};
  p.ascending = {{0.0, 1.0, 3.0}, {50.0, 25.0}};
  p.descending = {{0.0, 2.5, 3.0}, {20.0, 100.0}};
  p.parameters = {alpha_d, 0.5, 0.0, 0.5, 0.5};
  p.noise_v = 1.0;
  p.span = 3.0;
  return p;
}

// Splits at a quarter of the way.
TaxelPattern pattern_split_at(double beta) {
  TaxelPattern p = bent_pattern(0.25);
  p.parameters = {0.25, beta, 0.0, 0.25, beta};
  return p;
}

void check_reads(const TaxelPattern& p, double y, double x) {
  const ComposedCurve fall = curve_from(p, false, 100.0, 3.0, 100.0);
  CHECK(input_at(p, fall, y) == Approx(x));
  CHECK(piece_at(p, fall, y, 0).along(y) == Approx(x));
}

}  // namespace

TEST_CASE("fast curves: a piece of a fall is straight when its pattern rises by no more than is saturated") {
  // Above the split: it lies at 25 psi and 1.5, on the pattern at 1.25, which rises by 1.75. At 2, a third of the way
  // up, the pattern reads 1.25 + 1.75 / 3, 36.67 psi; a straight line a third of 75 psi more than 25.
  TaxelPattern upper = bent_pattern(0.25);
  upper.saturated = std::nextafter(1.75, 0.0);
  check_reads(upper, 2.0, 25.0 + 35.0 / 3.0);
  upper.saturated = 1.75;
  check_reads(upper, 2.0, 50.0);
  // Below it: at 75 psi and 1.5, on the pattern at 2.75. At 0.75 the pattern reads 1.375, 27.5 psi; a straight line
  // half of 75 psi.
  TaxelPattern lower = bent_pattern(0.75);
  lower.saturated = std::nextafter(2.75, 0.0);
  check_reads(lower, 0.75, 27.5);
  lower.saturated = 2.75;
  check_reads(lower, 0.75, 37.5);
}

TEST_CASE("fast curves: a turn at exactly a hundredth of the range from its end is an external branch's") {
  TaxelPattern p = bent_pattern(0.5);
  p.exact_outer = true;
  // Up from 1 psi and 0.02 the split's output is 1.51: on the pattern at 62.75 psi, by the formula at 50.5.
  CHECK(curve_from(p, true, 1.0, 0.02, 1.0).xs == Approx(62.75));
  CHECK(curve_from(p, true, 1.001, 0.02, 1.001).xs == Approx(1.001 + 0.5 * 98.999));
  // Down from 99 psi and 2.99 with a split at 49.5 psi, where the pattern has 2.475 of 3; by the formula half.
  CHECK(curve_from(p, false, 99.0, 2.99, 99.0).ys == Approx(2.475 / 3.0 * 2.99));
  CHECK(curve_from(p, false, 98.999, 2.99, 98.999).ys == Approx(0.5 * 2.99));
}

TEST_CASE("fast curves: at a turn, a split and the top the piece holds the output") {
  TaxelPattern p;
  p.x = {10.0, 50.0, 110.0};  // a range that does not begin at 0
  p.ascending = {{0.0, 1.0, 3.0}, {40.0, 30.0}};
  p.descending = {{0.0, 2.0, 3.0}, {20.0, 60.0}};
  p.parameters = {0.5, 0.5, 0.0, 0.5, 0.5};
  p.noise_v = 1.0;
  p.span = 3.0;
  const auto check_holds = [&](const ComposedCurve& curve, double y, double x) {
    CAPTURE(curve.ascending, y);
    const CurvePiece piece = piece_at(p, curve, y, 0);
    CHECK(piece.holds(y));
    CHECK(piece.along(y) == Approx(x));
    CHECK(input_at(p, curve, y) == Approx(x));
  };
  const ComposedCurve rise = curve_from(p, true, 50.0, 1.0, 50.0);  // its split: 80 psi, 2
  check_holds(rise, 0.5, 50.0);
  check_holds(rise, 1.0, 50.0);
  check_holds(rise, 2.0, 80.0);
  check_holds(rise, 3.0, 110.0);
  check_holds(rise, 3.5, 110.0);
  const ComposedCurve fall = curve_from(p, false, 80.0, 2.0, 80.0);  // its split: 45 psi, 1
  check_holds(fall, 2.5, 80.0);
  check_holds(fall, 2.0, 80.0);
  check_holds(fall, 1.0, 45.0);
  check_holds(fall, 0.0, 10.0);
  check_holds(fall, -0.5, 10.0);
  // Where the pattern below the split counts as saturated the way down is straight, from the range's begin on.
  p.saturated = 2.5;
  check_holds(curve_from(p, false, 80.0, 2.0, 80.0), 0.5, 10.0 + 0.5 * 35.0);
}

TEST_CASE("exact ends: a fall or rise whose split has the output of an end reads that end at this output") {
  const double little = 1e-12;
  const TaxelPattern low = pattern_split_at(0.0), high = pattern_split_at(1.0);
  for (const bool rises : {false, true}) {
    const double from = rises ? 0.0 : 100.0, output = rises ? 0.0 : 3.0;
    const ComposedCurve at_low = curve_from(low, rises, from, output, from),
                        at_high = curve_from(high, rises, from, output, from);
    CAPTURE(rises);
    CHECK(at_low.xs == Approx(25.0));
    for (const double bottom : {0.0, -1.0}) CHECK(input_at(low, at_low, bottom) == 0.0);
    CHECK(input_at(low, at_low, little) == Approx(25.0));
    CHECK(input_at(low, at_low, 3.0) == 100.0);
    for (const double top : {3.0, 4.0}) CHECK(input_at(high, at_high, top) == 100.0);
    CHECK(input_at(high, at_high, 3.0 - little) == Approx(25.0));
    CHECK(input_at(high, at_high, 0.0) == 0.0);
  }
}
