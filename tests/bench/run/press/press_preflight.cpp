// What a press plan is refused for, before anything moves.
#include "bench/run/press/press_preflight.h"

#include <catch2/catch.hpp>
#include <limits>

using namespace tactbench;
using bench::PressEnvelope;
using bench::PressOptions;
using bench::PressPlanned;

namespace {

const PressEnvelope kEnvelope{{25.0, 25.0, 35.0, 250.0, 250.0, 250.0}, 1.0, {{{0.0, 60.0}, {0.0, 60.0}, {0.0, 50.0}}}};
const PressPlanned kRing{{{30.0, 30.0}}, {2.0, 6.0, 10.0, 20.0, 30.0}};

std::string first(const PressPlanned& planned, const PressOptions& options = {},
                  const PressEnvelope& envelope = kEnvelope) {
  const auto complaints = bench::press_complaints(planned, options, envelope);
  return complaints.empty() ? "none" : complaints.front();
}

}  // namespace

TEST_CASE("press preflight: the paper's ring fits the SI-25 calibration and not the SI-12") {
  CHECK(first(kRing) == "none");
  PressEnvelope small = kEnvelope;
  small.force_range[2] = 17.0;
  const auto complaints = bench::press_complaints(kRing, {}, small);
  REQUIRE(complaints.size() == 3);  // 20 N, 30 N, and a force limit that nothing would see passed
  CHECK_THAT(complaints[0], Catch::StartsWith("20 N"));
  CHECK_THAT(complaints[0], Catch::Contains("17 N"));
}

TEST_CASE("press preflight: overshoot is speed times latency and stop time times stiffness, and counts") {
  CHECK(bench::overshoot_n(0.5, 0.02, 0.03, 100.0) == Approx(2.5));
  PressOptions fast;
  fast.servo_mm_per_s = 1.0;
  CHECK_THAT(first(kRing, fast), Catch::Contains("4.00 N of overshoot"));
  PressOptions hasty;
  hasty.approach_mm_per_s = 5.0;
  CHECK_THAT(first(kRing, hasty), Catch::Contains("the search at 5 mm/s"));
}

TEST_CASE("press preflight: places outside the axes, too small a force, coarse moves and not-a-number are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(first({{{61.0, 30.0}}, {2.0}}), Catch::Contains("x = 61 mm"));
  CHECK_THAT(first({{{30.0, -0.1}}, {2.0}}), Catch::Contains("y = -0.1 mm"));
  CHECK_THAT(first({{{nan, 30.0}}, {2.0}}), Catch::Contains("x = nan"));
  CHECK_FALSE(first({{{30.0, 30.0}}, {nan}}) == "none");
  CHECK_THAT(first({{{30.0, 30.0}}, {0.05}}), Catch::Contains("count as contact"));
  PressOptions deep;
  deep.deepest_z_mm = 50.5;
  CHECK_THAT(first(kRing, deep), Catch::Contains("deepest z"));
  PressOptions coarse;
  coarse.resolution_mm = 0.001;
  CHECK_THAT(first(kRing, coarse), Catch::Contains("smallest move"));
}
