// Refusals of a press plan before any motion: each limit at its edge and beyond it.
#include "bench/run/press/press.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/stage_steps.h"

using namespace tactbench;
using bench::PressEnvelope;
using bench::PressOptions;
using bench::PressPlanned;

namespace {

// Numbers that are exact in binary. 0.5 mm/s x (0.25 + 0.25) s x 8 N/mm: 2 N of overshoot; half of 32 N of Fz, as much
// as the bench's limit.
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
  options.max_z_mm = 50.0;
  return options;
}

const PressEnvelope kEdgeEnvelope{
    {25.0, 25.0, 32.0, 250.0, 250.0, 250.0}, 0.5, {{{0.0, 60.0}, {10.0, 60.0}, {0.0, 50.0}}}};

// One complaint for each row of `numbers`, which it has to name.
using Numbers = std::vector<std::vector<std::string>>;

void check_complaints(const std::vector<std::string>& complaints, const Numbers& numbers) {
  REQUIRE(complaints.size() == numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    for (const std::string& number : numbers[i]) {
      INFO(complaints[i] << ": " << number);
      CHECK(complaints[i].find(number) != std::string::npos);
    }
  }
}

void check_forces(const std::vector<double>& forces, const Numbers& numbers,
                  const PressOptions& options = exact_options()) {
  check_complaints(bench::press_complaints({{{0.0, 10.0}, {60.0, 60.0}}, forces}, options, kEdgeEnvelope), numbers);
}

}  // namespace

TEST_CASE("press preflight: the paper ring fits the SI-25 calibration but not the SI-12") {
  const PressPlanned ring{{{30.0, 30.0}}, {2.0, 6.0, 10.0, 20.0, 30.0}};
  PressEnvelope calibrated = {{25.0, 25.0, 35.0, 250.0, 250.0, 250.0}, 1.0, {{{0.0, 60.0}, {0.0, 60.0}, {0.0, 50.0}}}};
  CHECK(bench::press_complaints(ring, {}, calibrated).empty());
  calibrated.force_range[2] = 17.0;
  // 20 N, 30 N, and a force limit that nothing would see passed.
  check_complaints(bench::press_complaints(ring, {}, calibrated), {{"20 N", "17 N"}, {"30 N"}, {}});
}

TEST_CASE("press preflight: force with tolerance and overshoot must be within the range and above the contact limit") {
  CHECK(bench::overshoot_n(0.5, 0.02, 0.03, 100.0) == Approx(2.5));  // speed, latency and stop time, stiffness
  check_forces({1.0, 13.5}, {});
  check_forces({13.75}, {{"13.75 N", "2.00 N", "16 N"}, {"13.75 N", "2.00 N", "16 N"}});  // of the range, of the bench
  check_forces({0.75}, {{"0.75 N", "1 N"}});
  check_forces({std::numeric_limits<double>::quiet_NaN()}, {{}, {}, {}});
  PressOptions share = exact_options();
  share.tolerance_share = 0.0625;  // of 13.5 N more than 0.5 N
  check_forces({13.5}, {{"13.5 N"}, {"13.5 N"}}, share);
  check_forces({8.0}, {}, share);
}

TEST_CASE("press preflight: limit of the bench, search speed and smallest move") {
  PressOptions options = exact_options();
  options.force_limit_n = 16.5;
  check_forces({2.0}, {{"16.5 N", "16 N"}}, options);
  check_forces({}, {{}}, options);
  options = exact_options();
  options.approach_mm_per_s = 3.0;
  check_forces({2.0, 8.0}, {{"3 mm/s", "19.0 N", "8 N/mm", "16 N"}}, options);
  options.resolution_mm = 0.125;
  check_forces({}, {}, options);  // nothing is pressed
  options.approach_mm_per_s = 2.5;
  check_forces({8.0, 2.0, 4.0}, {{"1.000 N", "0.500 N", "2 N"}}, options);
}

TEST_CASE("press preflight: positions at and beyond the ends of each axis") {
  const auto check_place = [](double x_mm, double y_mm, double clear_mm, double deepest_mm, const Numbers& numbers) {
    PressOptions options = exact_options();
    options.clear_z_mm = clear_mm;
    options.max_z_mm = deepest_mm;
    check_complaints(bench::press_complaints({{{x_mm, y_mm}}, {2.0}}, options, kEdgeEnvelope), numbers);
  };
  check_place(0.0, 10.0, 0.0, 50.0, {});
  check_place(60.0, 60.0, 49.0, 50.0, {});
  check_place(-0.5, 9.5, 0.0, 50.0, {{"x = -0.5 mm", "0 to 60 mm"}, {"y = 9.5 mm", "10 to 60 mm"}});
  check_place(60.5, 60.5, -0.5, 50.5,
              {{"x = 60.5 mm"}, {"y = 60.5 mm"}, {"z = -0.5 mm", "0 to 50 mm"}, {"z = 50.5 mm", "0 to 50 mm"}});
  check_place(std::numeric_limits<double>::quiet_NaN(), 30.0, 0.0, 50.0, {{"x = nan"}});
  check_place(0.0, 10.0, 50.0, 50.0, {{}});  // clear is not above the deepest
}

TEST_CASE("press options: limits come from the bench, speeds from the recipe") {
  bench::BenchConfig config;
  config.stage.emplace();
  config.force.emplace();
  config.limits.clear_z_mm = 21.0;
  config.limits.contact_n = 0.7;
  config.limits.force_n = {1.0, 2.0, 30.0};
  sequences::Recipe recipe;
  recipe.press.approach_mm_per_s = 0.25;
  recipe.press.contact_n = 0.3;
  recipe.press.servo_mm_per_s = 0.02;
  recipe.press.clear_mm = 3.0;
  PressOptions options = bench::press_options(config, recipe);
  CHECK(options.clear_z_mm == 21.0);
  CHECK(options.safe_force_n == 0.7);
  CHECK(options.force_limit_n == 30.0);
  CHECK(options.approach_mm_per_s == 0.25);
  CHECK(options.contact_n == 0.3);
  CHECK(options.servo_mm_per_s == 0.02);
  CHECK(options.clear_mm == 3.0);
  config.limits.force_n[2] = 40.0;
  CHECK(bench::press_options(config, recipe).force_limit_n == 33.0);  // the press's own is less
  recipe.press.positions_mm = {{30.0, 62.0}};
  recipe.press.forces_n = {2.0};
  config.stage->options.axes[1].high = devices::Millimetres(61.0);
  config.force->overload_share = 0.9;
  const auto complaints = bench::press_complaints(recipe, config, {25.0, 25.0, 35.0, 250.0, 250.0, 250.0});
  REQUIRE(complaints.size() == 2);
  CHECK_THAT(complaints[0], Catch::Contains("33 N") && Catch::Contains("31.5 N"));
  CHECK_THAT(complaints[1], Catch::StartsWith("y = 62 mm"));
}
