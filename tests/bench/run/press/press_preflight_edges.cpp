// Each limit of a press plan at its edge and beyond it, in all words; numbers that are exact in binary.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/run/press/press_preflight.h"

using namespace tactbench;
using bench::PressEnvelope;
using bench::PressOptions;
using bench::PressPlanned;

namespace {

using Complaints = std::vector<std::string>;

// 0.5 mm/s x (0.25 + 0.25) s x 8 N/mm: 2 N of overshoot; half of 32 N of Fz, as much as the bench's limit.
PressOptions exact_options() {
  PressOptions options;
  options.servo_mm_per_s = 0.5;
  options.force_latency_s = 0.25;
  options.stop_time_s = 0.25;
  options.poll_interval_s = 0.25;
  options.stiffest_n_per_mm = 8.0;
  options.tolerance_n = 0.5;
  options.tolerance_share = 0.0;
  options.force_limit_n = 16.0;
  options.contact_n = 1.0;
  options.approach_mm_per_s = 2.5;  // 1 N + 2.5 mm/s x 0.75 s x 8 N/mm: 16 N
  options.resolution_mm = 0.0625;
  options.clear_z_mm = 0.0;
  options.deepest_z_mm = 50.0;
  return options;
}

const PressEnvelope kEdgeEnvelope{
    {25.0, 25.0, 32.0, 250.0, 250.0, 250.0}, 0.5, {{{0.0, 60.0}, {10.0, 60.0}, {0.0, 50.0}}}};

Complaints edge_complaints(const std::vector<double>& forces, const PressOptions& options = exact_options()) {
  return bench::press_complaints({{{0.0, 10.0}, {60.0, 60.0}}, forces}, options, kEdgeEnvelope);
}

}  // namespace

TEST_CASE(
    "press preflight edges: forces with tolerance and overshoot up to the range, down to what counts as contact") {
  CHECK(edge_complaints({1.0, 13.5}).empty());
  CHECK(edge_complaints({13.75}) ==
        Complaints{"13.75 N, with its tolerance and 2.00 N of overshoot (0.5 mm/s x 0.5 s x 8 N/mm), are beyond the 16 "
                   "N of Fz that the fitted calibration goes to",
                   "13.75 N, with its tolerance and 2.00 N of overshoot, are beyond the bench's force limit of 16 N"});
  CHECK(edge_complaints({0.75}) == Complaints{"0.75 N are less than the 1 N that count as contact"});
  PressOptions share = exact_options();
  share.tolerance_share = 0.0625;  // of 13.5 N more than 0.5 N
  CHECK(edge_complaints({13.5}, share).size() == 2);
  CHECK(edge_complaints({8.0}, share).empty());
}

TEST_CASE("press preflight edges: the bench's limit, the search and the smallest move") {
  PressOptions options = exact_options();
  options.force_limit_n = 16.5;
  CHECK(edge_complaints({2.0}, options) ==
        Complaints{"the bench's force limit of 16.5 N is beyond the 16 N that the fitted calibration goes to: nothing "
                   "would see it passed"});
  CHECK(edge_complaints({}, options).size() == 1);
  options = exact_options();
  options.approach_mm_per_s = 3.0;
  CHECK(edge_complaints({2.0, 8.0}, options) ==
        Complaints{"the search at 3 mm/s may press 19.0 N at 8 N/mm before it stops, beyond the bench's force limit of "
                   "16 N"});
  options.resolution_mm = 0.125;
  CHECK(edge_complaints({}, options).empty());  // nothing is pressed
  options.approach_mm_per_s = 2.5;
  CHECK(edge_complaints({8.0, 2.0, 4.0}, options) ==
        Complaints{"the smallest move of z changes the force by 1.000 N at 8 N/mm, more than the tolerance of 0.500 N "
                   "at 2 N"});
}

TEST_CASE("press preflight edges: places at the ends of each axis and beyond") {
  const auto complaints_at = [](double x_mm, double y_mm, double clear_mm, double deepest_mm) {
    PressOptions options = exact_options();
    options.clear_z_mm = clear_mm;
    options.deepest_z_mm = deepest_mm;
    return bench::press_complaints({{{x_mm, y_mm}}, {2.0}}, options, kEdgeEnvelope);
  };
  CHECK(complaints_at(0.0, 10.0, 0.0, 50.0).empty());
  CHECK(complaints_at(60.0, 60.0, 49.0, 50.0).empty());
  CHECK(complaints_at(-0.5, 9.5, 0.0, 50.0) ==
        Complaints{"x = -0.5 mm is outside the axis' 0 to 60 mm", "y = 9.5 mm is outside the axis' 10 to 60 mm"});
  CHECK(complaints_at(60.5, 60.5, -0.5, 50.5) == Complaints{"x = 60.5 mm is outside the axis' 0 to 60 mm",
                                                            "y = 60.5 mm is outside the axis' 10 to 60 mm",
                                                            "clear z = -0.5 mm is outside the axis' 0 to 50 mm",
                                                            "deepest z = 50.5 mm is outside the axis' 0 to 50 mm"});
  CHECK(complaints_at(0.0, 10.0, 50.0, 50.0) == Complaints{"clear z is not above the deepest z"});
}
