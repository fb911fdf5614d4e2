// Measuring intervals by hand.
#include "analysis/statistics/uncertainty/measuring_interval.h"

#include <catch2/catch.hpp>

using namespace tactbench::analysis;

namespace {

// Two taxels; up at 0, 10, ..., 50 psi, down at 0 and 10.
ConditionUncertainty stated() {
  ConditionUncertainty out;
  out.pressure_psi = {0, 10, 20, 30, 40, 50, 0, 10};
  out.up = {true, true, true, true, true, true, false, false};
  out.expanded_psi = {1, 1, 1, 2, 3, 1, 1, 1, 1, 1, 1, 1, 5, 5, 5, 5};
  out.error_psi.assign(16, 0.0);
  return out;
}

constexpr std::size_t kBoth[] = {0, 1}, kFirst[] = {0};

}  // namespace

TEST_CASE("measuring interval: is the longest run of levels, from either end, a single one, or none") {
  const ConditionUncertainty known = stated();
  const auto of = [&](double mpe, bool up = true) { return measuring_interval(known, up, mpe, kBoth); };
  // Level 20 has U of 3 psi of one taxel, level 10 of 2.
  CHECK((of(3.0).any && of(3.0).low_psi == 0.0 && of(3.0).high_psi == 50.0));
  CHECK((of(2.99).low_psi == 30.0 && of(2.99).high_psi == 50.0));
  CHECK((of(1.0).low_psi == 30.0 && of(1.0).high_psi == 50.0));
  CHECK_FALSE(of(0.99).any);
  CHECK_FALSE(of(4.99, false).any);
  CHECK((of(5.0, false).low_psi == 0.0 && of(5.0, false).high_psi == 10.0));
  CHECK_FALSE(measuring_interval({}, true, 9.0, kBoth).any);
}

TEST_CASE("measuring interval: known error adds to U, a share of taxels suffices, taxels without U are outside") {
  ConditionUncertainty known = stated();
  known.error_psi[2 * 4] = -0.5;  // at 40 psi of the first taxel
  const MeasuringInterval both = measuring_interval(known, true, 1.4, kBoth);
  CHECK((both.low_psi == 0.0 && both.high_psi == 0.0));  // of runs of equal length the lowest
  CHECK(measuring_interval(known, true, 1.5, kBoth).low_psi == 30.0);
  CHECK(measuring_interval(known, true, 1.4, kFirst).high_psi == 10.0);
  const MeasuringInterval half = measuring_interval(known, true, 1.4, kBoth, 0.5);
  CHECK((half.low_psi == 0.0 && half.high_psi == 50.0));
  known.expanded_psi[2 * 2] = known.expanded_psi[2 * 2 + 1] = kNan;  // at 20 psi
  const MeasuringInterval beside = measuring_interval(known, true, 9.0, kBoth, 0.5);
  CHECK((beside.low_psi == 30.0 && beside.high_psi == 50.0));
}
