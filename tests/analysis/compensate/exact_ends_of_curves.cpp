// Outputs that lie exactly on an end of a curve whose split lies there.
#include <catch2/catch.hpp>

#include "analysis/compensate/composed_curve.h"

using namespace tactbench::analysis;

namespace {

// 0 to 100 psi are 3 units of output: up by 1 at 50 psi, down by 2.5. Splits at a quarter of the way.
TaxelPattern pattern_split_at(double beta) {
  TaxelPattern p;
  p.x = {0.0, 50.0, 100.0};
  p.ascending = {{0.0, 1.0, 3.0}, {50.0, 25.0}};
  p.descending = {{0.0, 2.5, 3.0}, {20.0, 100.0}};
  p.parameters = {0.25, beta, 0.0, 0.25, beta};
  p.noise_v = 1.0;
  p.span = 3.0;
  return p;
}

}  // namespace

TEST_CASE("exact ends: a fall or rise whose split has the output of an end reads that end at this output") {
  const double little = 1e-12;
  const TaxelPattern low = pattern_split_at(0.0), high = pattern_split_at(1.0);
  const ComposedCurve falls_low = curve_from(low, false, 100.0, 3.0, 100.0);
  CHECK(falls_low.xs == Approx(25.0));
  CHECK(input_at(low, falls_low, 0.0) == 0.0);
  CHECK(input_at(low, falls_low, -1.0) == 0.0);
  CHECK(input_at(low, falls_low, little) == Approx(25.0));
  CHECK(input_at(low, falls_low, 3.0) == 100.0);
  const ComposedCurve falls_high = curve_from(high, false, 100.0, 3.0, 100.0);
  CHECK(input_at(high, falls_high, 3.0) == 100.0);
  CHECK(input_at(high, falls_high, 3.0 - little) == Approx(25.0));
  CHECK(input_at(high, falls_high, 0.0) == 0.0);
  const ComposedCurve rises_low = curve_from(low, true, 0.0, 0.0, 0.0);
  CHECK(rises_low.xs == Approx(25.0));
  CHECK(input_at(low, rises_low, 0.0) == 0.0);
  CHECK(input_at(low, rises_low, little) == Approx(25.0));
  CHECK(input_at(low, rises_low, 3.0) == 100.0);
  const ComposedCurve rises_high = curve_from(high, true, 0.0, 0.0, 0.0);
  CHECK(input_at(high, rises_high, 3.0) == 100.0);
  CHECK(input_at(high, rises_high, 4.0) == 100.0);
  CHECK(input_at(high, rises_high, 3.0 - little) == Approx(25.0));
}
