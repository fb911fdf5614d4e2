// Registration of the stage to the taxels from frames made here: the given transform is found, and ambiguous touches
// are refused.
#include "bench/run/press/registration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "tests/devices/fault_of.h"

using namespace tactbench;
using bench::MountRegistration;
using bench::Touch;
using devices::fault_id_of;
using devices::fault_of;

namespace {

constexpr int kRows = 16, kColumns = 16;
constexpr double kPitchMm = 2.54;
constexpr double kOffsetCounts = 900.0;

struct Mount {
  double angle_deg = 0.0, x_mm = 0.0, y_mm = 0.0, scale = 1.0;
  bool flipped = false;
};

// Stage position over taxel coordinates `at`.
Touch place(const Mount& mount, double taxel_x_mm, double taxel_y_mm) {
  const double angle = mount.angle_deg * std::numbers::pi / 180.0;
  const double x = mount.scale * taxel_x_mm;
  const double y = mount.scale * (mount.flipped ? -taxel_y_mm : taxel_y_mm);
  return {mount.x_mm + std::cos(angle) * x - std::sin(angle) * y,
          mount.y_mm + std::sin(angle) * x + std::cos(angle) * y,
          {}};
}

const std::vector<double> kBaseline(kRows* kColumns, kOffsetCounts);

// A blunt point there, a Gaussian of 2.5 mm, over the baseline.
std::vector<double> frame_of(double taxel_x_mm, double taxel_y_mm) {
  std::vector<double> frame = kBaseline;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double away = std::hypot(column * kPitchMm - taxel_x_mm, row * kPitchMm - taxel_y_mm);
      frame[static_cast<std::size_t>(row * kColumns + column)] += 20000.0 * std::exp(-away * away / (2.0 * 2.5 * 2.5));
    }
  }
  return frame;
}

std::vector<Touch> touches(const Mount& mount, const std::vector<std::pair<double, double>>& places) {
  std::vector<Touch> made;
  for (const auto& [x, y] : places) {
    Touch touch = place(mount, x, y);
    touch.taxel_mm = bench::touch_centre_mm(frame_of(x, y), kBaseline, kRows, kColumns, kPitchMm, 500.0);
    made.push_back(touch);
  }
  return made;
}

const std::vector<std::pair<double, double>> kThree = {{8.1, 9.3}, {29.0, 10.2}, {12.4, 27.7}};
const std::vector<std::pair<double, double>> kFour = {{8.1, 9.3}, {29.0, 10.2}, {27.3, 28.8}, {9.4, 27.7}};

}  // namespace

TEST_CASE("registration: rotated, shifted and flipped mounts are recovered") {
  const bool flipped = GENERATE(false, true);
  const double angle = GENERATE(0.0, 3.5, -92.0, 179.0);
  const auto& places = GENERATE_REF(values({kThree, kFour}));
  const Mount mount{angle, 21.3, 30.9, 1.0, flipped};
  const MountRegistration found = bench::register_mount(touches(mount, places), kPitchMm);
  CHECK(found.flipped == flipped);
  CHECK(found.angle_deg == Approx(angle).margin(0.15));
  CHECK(found.offset_mm[0] == Approx(21.3).margin(0.08));
  CHECK(found.offset_mm[1] == Approx(30.9).margin(0.08));
  CHECK(found.scale == Approx(1.0).margin(0.005));
  CHECK(found.rms_mm < 0.05);
  CHECK(found.other_rms_mm > 2.0);
  const Touch there = place(mount, 20.0, 14.0);
  CHECK(std::hypot(found.stage_mm({20.0, 14.0})[0] - there.x_mm, found.stage_mm({20.0, 14.0})[1] - there.y_mm) < 0.1);
}

TEST_CASE("registration: a pitch other than the nominal one gives the scale, and the text has every touch") {
  const MountRegistration found = bench::register_mount(touches({10.0, 0.0, 0.0, 1.02, false}, kFour), kPitchMm);
  CHECK(found.scale == Approx(1.02).margin(0.005));
  const auto text = nlohmann::json::parse(found.json());
  CHECK(text["pitch_mm"] == kPitchMm);
  CHECK(text["touches"].size() == 4);
  CHECK(text["touches"][2]["residual_mm"].get<double>() == found.residual_mm[2]);
  CHECK(text["flipped"] == false);
}

TEST_CASE("registration: the best transform and the residual of the rejected mirror agree with hand-computed values") {
  // Corners of 20 x 10 mm. Their mirror image fits best along the longer side: squares of 400 and 100 about the centre,
  // scale (400 - 100) / 500, what is left 500 - 300^2 / 500 = 320 over four corners.
  const bool flipped = GENERATE(false, true);
  std::vector<Touch> corners;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{20.0, 0.0}, std::pair{20.0, 10.0}, std::pair{0.0, 10.0}})
    corners.push_back({5.0 + x, 7.0 + (flipped ? -y : y), {x, y}});
  const MountRegistration found = bench::register_mount(corners, kPitchMm);
  CHECK(found.flipped == flipped);
  CHECK(found.angle_deg == Approx(0.0).margin(1e-9));
  CHECK(found.scale == Approx(1.0));
  CHECK(found.offset_mm[0] == Approx(5.0));
  CHECK(found.offset_mm[1] == Approx(7.0));
  CHECK(found.rms_mm == Approx(0.0).margin(1e-9));
  CHECK(found.other_rms_mm == Approx(std::sqrt(80.0)));
  CHECK(nlohmann::json::parse(found.json())["other_flip_rms_mm"].get<double>() == found.other_rms_mm);
}

TEST_CASE("registration: the centre of a touch agrees with hand-computed values") {
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
  CHECK(id(frame, 3, 4, std::nextafter(10.0, 11.0)) == "TB-MOUNT-NO-TOUCH");
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
  CHECK_THAT(fault.value().what(), Catch::Contains("2") && Catch::Contains("3"));
  CHECK(fault_id_of([&] {
          (void)bench::touch_centre_mm(std::vector<double>(12, std::nan("")), baseline, 3, 4, 2.0, 1.0);
        }) == "TB-MOUNT-NO-TOUCH");
}

TEST_CASE("registration: stage position over a taxel of a turned, scaled and flipped mount") {
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

TEST_CASE("registration: limits of the residuals, their rms and the spread") {
  // A square of 10 mm whose corners lie 0.1 mm in and out along the diagonals: turn, shift and scale stay, rms 0.1.
  const double in = 0.1 / std::sqrt(2.0);
  std::vector<Touch> square;
  int k = 0;
  for (const auto& [x, y] : {std::pair{-5.0, -5.0}, std::pair{5.0, -5.0}, std::pair{5.0, 5.0}, std::pair{-5.0, 5.0}}) {
    const double out = k++ % 2 == 0 ? in : -in;
    square.push_back({x + std::copysign(out, out * x), y + std::copysign(out, out * y), {x, y}});
  }
  bench::RegistrationOptions options;
  options.max_rms_mm = 0.1 + 1e-9;
  const MountRegistration made = bench::register_mount(square, 2.5, options);
  CHECK(made.rms_mm == Approx(0.1));
  CHECK(made.scale == Approx(1.0));
  CHECK(made.angle_deg == Approx(0.0).margin(1e-9));
  CHECK(made.pitch_mm == 2.5);
  REQUIRE(made.residual_mm.size() == 4);
  for (const double residual : made.residual_mm) CHECK(residual == Approx(0.1));
  const auto text = nlohmann::json::parse(made.json());
  CHECK(text["touches"][1]["stage_mm"][1].get<double>() == square[1].y_mm);
  CHECK(text["touches"][1]["taxel_mm"][0].get<double>() == 5.0);
  CHECK(text["rms_mm"].get<double>() == made.rms_mm);
  CHECK(text["angle_deg"].get<double>() == made.angle_deg);
  options.max_rms_mm = 0.1 - 1e-9;
  CHECK(fault_id_of([&] { (void)bench::register_mount(square, 2.5, options); }) == "TB-MOUNT-RESIDUAL");
  // Three in a row and one 8 mm off: 8 x sqrt(3) / 4 mm from their line, root mean square.
  std::vector<Touch> kite;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{15.0, 8.0}, std::pair{30.0, 0.0}, std::pair{15.0, 0.0}})
    kite.push_back({x, y, {x, y}});
  options = {};
  options.min_spread_mm = 2.0 * std::sqrt(3.0) - 1e-9;
  CHECK(bench::register_mount(kite, 2.5, options).rms_mm < 1e-9);
  options.min_spread_mm = 2.0 * std::sqrt(3.0) + 1e-9;
  CHECK(fault_id_of([&] { (void)bench::register_mount(kite, 2.5, options); }) == "TB-MOUNT-COLLINEAR");
  kite.resize(3);
  CHECK_FALSE(bench::register_mount(kite, 2.5).flipped);
  kite.resize(2);
  CHECK(fault_id_of([&] { (void)bench::register_mount(kite, 2.5); }) == "TB-MOUNT-TOUCHES");
}
