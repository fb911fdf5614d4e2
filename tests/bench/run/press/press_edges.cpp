// The preflight of a press plan at the edges of its limits, and the registration's numbers on frames of a few taxels.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/config/config.h"
#include "bench/run/press/press_preflight.h"
#include "bench/run/press/registration.h"
#include "bench/run/stage_steps.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using bench::MountRegistration;
using bench::PressEnvelope;
using bench::PressOptions;
using bench::Touch;
using devices::fault_id_of;
using devices::fault_of;

namespace {

const PressEnvelope kWide{{25.0, 25.0, 35.0, 250.0, 250.0, 250.0}, 1.0, {{{0.0, 60.0}, {1.0, 61.0}, {0.0, 50.0}}}};

std::vector<std::string> complaints_of(const std::vector<double>& forces, const PressOptions& options = {},
                                       const PressEnvelope& envelope = kWide) {
  return bench::press_complaints({{}, forces}, options, envelope);
}

double just_below(double value) { return std::nextafter(value, -1e300); }
double just_above(double value) { return std::nextafter(value, 1e300); }

}  // namespace

TEST_CASE("press preflight: a force with tolerance and overshoot may be just the range and just the limit") {
  PressOptions options;
  const double most_n = 30.0 + options.tolerance(30.0) +
                        bench::overshoot_n(options.servo_mm_per_s, options.force_latency_s, options.stop_time_s,
                                           options.stiffest_n_per_mm);
  CHECK(most_n == Approx(30.0 + 0.3 + 0.2));
  PressEnvelope envelope = kWide;
  options.force_limit_n = envelope.force_range[2] = most_n;
  CHECK(complaints_of({30.0}, options, envelope).empty());
  options.force_limit_n = just_below(most_n);
  REQUIRE(complaints_of({30.0}, options, envelope).size() == 1);
  CHECK(complaints_of({30.0}, options, envelope)[0] ==
        "30 N, with its tolerance and 0.20 N of overshoot, are beyond the bench's force limit of 30.5 N");
  envelope.force_range[2] = just_below(most_n);
  const auto both = complaints_of({30.0}, options, envelope);
  REQUIRE(both.size() == 2);
  CHECK_THAT(both[0], Catch::Contains("0.20 N of overshoot (0.05 mm/s x 0.04 s x 100 N/mm), are beyond the 30.5 N"));
  envelope.force_range[2] = 2.0 * most_n;
  envelope.overload_share = 0.5;
  CHECK(complaints_of({29.0}, options, envelope).empty());
  envelope.overload_share = 0.49;
  CHECK(complaints_of({29.0}, options, envelope).size() == 1);  // the limit itself is beyond it
}

TEST_CASE("press preflight: contact, search and the smallest step, each to its edge") {
  CHECK(complaints_of({0.2}).empty());
  const auto light = complaints_of({just_below(0.2)});
  REQUIRE(light.size() == 1);
  CHECK(light[0] == "0.2 N are less than the 0.2 N that count as contact");
  PressOptions options;
  options.force_limit_n = 0.2 + bench::overshoot_n(0.5, 0.04 + 0.02, 0.02, 100.0);
  CHECK(options.force_limit_n == Approx(4.2));
  CHECK(complaints_of({2.0}, options).empty());
  options.force_limit_n = just_below(options.force_limit_n);
  const auto search = complaints_of({2.0}, options);
  REQUIRE(search.size() == 1);
  CHECK(search[0] ==
        "the search at 0.5 mm/s may press 4.2 N at 100 N/mm before it stops, beyond the bench's force limit of 4.2 N");
  CHECK(complaints_of({}, options).empty());
  PressOptions coarse;
  coarse.resolution_mm = 0.0005;
  CHECK(complaints_of({2.0}, coarse).empty());
  coarse.resolution_mm = 0.002;  // 0.2 N: too much for 2 N, not for 30 N
  CHECK(complaints_of({30.0}, coarse).empty());
  const auto step = complaints_of({2.0, 30.0}, coarse);
  REQUIRE(step.size() == 1);
  CHECK(step[0] ==
        "the smallest move of z changes the force by 0.200 N at 100 N/mm, more than the tolerance of 0.050 N at 2 N");
}

TEST_CASE("press preflight: places at the ends of the axes are inside, each axis has its own") {
  const auto at = [](double x_mm, double y_mm) {
    return bench::press_complaints({{{x_mm, y_mm}}, {2.0}}, {}, kWide).size();
  };
  CHECK(at(0.0, 1.0) == 0);
  CHECK(at(60.0, 61.0) == 0);
  CHECK(at(just_below(0.0), 30.0) == 1);
  CHECK(at(just_above(60.0), 30.0) == 1);
  CHECK(at(30.0, just_below(1.0)) == 1);
  CHECK(at(30.0, just_above(61.0)) == 1);
  PressOptions options;
  options.clear_z_mm = options.deepest_z_mm = 40.0;
  CHECK(bench::press_complaints({{}, {}}, options, kWide) ==
        std::vector<std::string>{"clear z is not above the deepest z"});
  options.clear_z_mm = just_below(40.0);
  CHECK(bench::press_complaints({{}, {}}, options, kWide).empty());
  options.clear_z_mm = -1.0;
  CHECK(bench::press_complaints({{}, {}}, options, kWide) ==
        std::vector<std::string>{"clear z = -1 mm is outside the axis' 0 to 50 mm"});
}

TEST_CASE("press options of a run: the bench's limits and the recipe's own speeds") {
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
  CHECK_THAT(complaints[0], Catch::Contains("force limit of 33 N is beyond the 31.5 N"));
  CHECK(complaints[1] == "y = 62 mm is outside the axis' 0 to 61 mm");
}

TEST_CASE("registration: the centre of a touch by hand") {
  // 3 rows of 4; the peak 10, threshold 1: weights 9 at (1, 1), 4 at (1, 2), 1 at (2, 1); what is below counts nothing.
  std::vector<double> frame(12, 5.0);
  const std::vector<double> baseline(12, 5.0);
  frame[1 * 4 + 1] += 10.0;
  frame[1 * 4 + 2] += 5.0;
  frame[2 * 4 + 1] += 2.0;
  frame[0 * 4 + 3] += 1.0;
  frame[0 * 4 + 0] -= 4.0;
  const auto centre = bench::touch_centre_mm(frame, baseline, 3, 4, 2.0, 10.0);
  CHECK(centre[0] == Approx(2.0 * (9.0 * 1 + 4.0 * 2 + 1.0 * 1) / 14.0));
  CHECK(centre[1] == Approx(2.0 * (9.0 * 1 + 4.0 * 1 + 1.0 * 2) / 14.0));
  const auto sharp = bench::touch_centre_mm(frame, baseline, 3, 4, 2.0, 10.0, 0.4);
  CHECK(sharp[0] == Approx(2.0 * (6.0 * 1 + 1.0 * 2) / 7.0));
  const auto id = [&](const std::vector<double>& made, int rows, int columns, double least) {
    return fault_id_of([&] { (void)bench::touch_centre_mm(made, baseline, rows, columns, 2.0, least); });
  };
  CHECK(id(frame, 3, 4, just_above(10.0)) == "TB-MOUNT-NO-TOUCH");
  CHECK_THROWS_AS(bench::touch_centre_mm(frame, baseline, 3, 5, 2.0, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(bench::touch_centre_mm(frame, std::vector<double>(11), 3, 4, 2.0, 1.0), std::invalid_argument);
  for (std::size_t i = 0; i < 12; ++i) {
    std::vector<double> one = baseline;
    one[i] += 10.0;
    CHECK(id(one, 3, 4, 1.0) == (i == 5 || i == 6 ? "none" : "TB-MOUNT-EDGE"));
  }
  std::vector<double> edge = baseline;
  edge[2 * 4 + 3] += 10.0;
  const auto fault = fault_of([&] { (void)bench::touch_centre_mm(edge, baseline, 3, 4, 2.0, 1.0); });
  CHECK_THAT(fault.value().what(), Catch::Contains("row 2, column 3"));
  CHECK(fault_id_of([&] {
          (void)bench::touch_centre_mm(std::vector<double>(12, std::nan("")), baseline, 3, 4, 2.0, 1.0);
        }) == "TB-MOUNT-NO-TOUCH");
}

TEST_CASE("registration: stage position over a taxel when turned, scaled and flipped") {
  MountRegistration mount;
  mount.angle_deg = 30.0;
  mount.offset_mm = {3.0, -2.0};
  mount.scale = 2.0;
  const double c = std::sqrt(0.75), s = 0.5;
  CHECK(mount.stage_mm({1.0, 5.0})[0] == Approx(3.0 + c * 2.0 - s * 10.0));
  CHECK(mount.stage_mm({1.0, 5.0})[1] == Approx(-2.0 + s * 2.0 + c * 10.0));
  mount.flipped = true;
  CHECK(mount.stage_mm({1.0, 5.0})[0] == Approx(3.0 + c * 2.0 + s * 10.0));
  CHECK(mount.stage_mm({1.0, 5.0})[1] == Approx(-2.0 + s * 2.0 - c * 10.0));
}

TEST_CASE("registration: residuals, their mean square and the spread, to their limits") {
  // A square of 10 mm whose corners lie 0.1 mm in and out along the diagonals: turn, shift and scale stay, rms 0.1.
  const double in = 0.1 / std::sqrt(2.0);
  std::vector<Touch> square;
  int k = 0;
  for (const auto& [x, y] : {std::pair{-5.0, -5.0}, std::pair{5.0, -5.0}, std::pair{5.0, 5.0}, std::pair{-5.0, 5.0}}) {
    const double out = k++ % 2 == 0 ? in : -in;
    square.push_back({x + std::copysign(out, out * x), y + std::copysign(out, out * y), {x, y}});
  }
  bench::RegistrationOptions options;
  options.most_rms_mm = 0.1 + 1e-9;
  const MountRegistration made = bench::register_mount(square, 2.5, options);
  CHECK(made.rms_mm == Approx(0.1));
  CHECK(made.scale == Approx(1.0));
  CHECK(made.angle_deg == Approx(0.0).margin(1e-9));
  CHECK(made.pitch_mm == 2.5);
  REQUIRE(made.residual_mm.size() == 4);
  for (const double residual : made.residual_mm) CHECK(residual == Approx(0.1));
  const auto json = nlohmann::json::parse(made.json());
  CHECK(json["touches"][1]["stage_mm"][1].get<double>() == square[1].y_mm);
  CHECK(json["touches"][1]["taxel_mm"][0].get<double>() == 5.0);
  CHECK(json["rms_mm"].get<double>() == made.rms_mm);
  CHECK(json["angle_deg"].get<double>() == made.angle_deg);
  options.most_rms_mm = 0.1 - 1e-9;
  CHECK(fault_id_of([&] { (void)bench::register_mount(square, 2.5, options); }) == "TB-MOUNT-RESIDUAL");
  // Three in a row and one 8 mm off: 8 x sqrt(3) / 4 mm from their line, root mean square.
  std::vector<Touch> kite;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{15.0, 8.0}, std::pair{30.0, 0.0}, std::pair{15.0, 0.0}})
    kite.push_back({x, y, {x, y}});
  options = {};
  options.least_spread_mm = 2.0 * std::sqrt(3.0) - 1e-9;
  CHECK(bench::register_mount(kite, 2.5, options).rms_mm < 1e-9);
  options.least_spread_mm = 2.0 * std::sqrt(3.0) + 1e-9;
  CHECK(fault_id_of([&] { (void)bench::register_mount(kite, 2.5, options); }) == "TB-MOUNT-COLLINEAR");
  kite.resize(3);
  CHECK_FALSE(bench::register_mount(kite, 2.5).flipped);
  kite.resize(2);
  CHECK(fault_id_of([&] { (void)bench::register_mount(kite, 2.5); }) == "TB-MOUNT-TOUCHES");
}
