// The press on an ideal stage: where it permits moves, what a level's reading contains, and when a branch breaks.

#include "bench/run/press/press.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/press/registration.h"
#include "bench/run/stage_steps.h"
#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::MountRegistration;
using bench::Press;
using bench::PressEnvelope;
using bench::PressOptions;
using bench::PressPlanned;
using bench::PressReading;
using bench::Touch;
using devices::Axis;
using devices::fault_id_of;
using devices::fault_of;
using std::chrono::milliseconds;

namespace {

struct PressBed : IdealBed {
  explicit PressBed(IdealForce::Law law, const bench::PressOptions& given = ideal_options())
      : IdealBed(std::move(law), given), press(stage, force, clock, given, hooks) {}
  PressReading go(double force_n, Branch branch, double dwell_s, bool hold_force = false) {
    return press.press({force_n, branch, dwell_s, hold_force}, [this] {
      ++frames;
      clock.wait_until(clock.now() + milliseconds(30));
      if (on_frame) on_frame();
    });
  }
  Press press;
  int frames = 0;
  std::function<void()> on_frame;
};

}  // namespace

TEST_CASE("press on an ideal stage: axis ends and speeds come from the bench options") {
  bench::BenchConfig config;
  CHECK_THROWS_AS(bench::press_options(config), std::logic_error);
  config.stage.emplace();
  auto& axes = config.stage->options.axes;
  axes[2].low = devices::Millimetres(1.5);
  axes[2].high = devices::Millimetres(42.0);
  axes[2].maximum_speed = devices::MillimetresPerSecond(7.0);
  axes[0].maximum_speed = devices::MillimetresPerSecond(5.0);
  axes[1].maximum_speed = devices::MillimetresPerSecond(3.0);
  const bench::PressOptions options = bench::press_options(config);
  CHECK(options.clear_z_mm == 1.5);
  CHECK(options.max_z_mm == Approx(41.99));
  CHECK(options.travel_mm_per_s == 7.0);
  CHECK(options.travel_xy_mm_per_s == 3.0);
}

TEST_CASE("press on an ideal stage: home moves z first, tare removes the offset and reports its drift") {
  PressBed bed(spring(20.0));
  bed.press.home();
  CHECK(bed.stage.homed_order == std::vector<Axis>{Axis::kZ, Axis::kX, Axis::kY});
  bed.force.offset_n = 1.5;
  bed.clock.wait_until(milliseconds(11));
  const bench::TareReading first = bed.press.tare();
  CHECK(first.removed.wrench.force_n[2] == 1.5);
  CHECK_FALSE(first.drift);
  CHECK(bed.force.biased_by == 50);
  bed.force.offset_n = 1.75;
  const bench::TareReading second = bed.press.tare();
  REQUIRE(second.drift);
  CHECK(second.drift->force_n[2] == 0.25);
  CHECK(second.drift->torque_nmm[1] == 0.5);
  REQUIRE(bed.events.size() == 3);
  CHECK(bed.events[0].first == "home");
  CHECK_THAT(bed.events[1].second, Catch::Contains("1.500 N"));
  CHECK_THAT(bed.events[2].second, Catch::Contains("1.750 N") && Catch::Contains("0.250 N"));
}

TEST_CASE("press on an ideal stage: x and y move only if z is clear and no force is measured") {
  PressBed bed(spring(20.0));
  bed.stage.put(Axis::kZ, 10.001);
  bed.stage.put(Axis::kX, 1.0);
  CHECK(fault_id_of([&] { bed.press.move_xy(3.0, 5.0); }) == "none");
  CHECK(bed.stage.mm(Axis::kX) == 3.0);
  CHECK(bed.stage.mm(Axis::kY) == 5.0);
  CHECK(bed.clock.now() == milliseconds(1250 + 50));  // the longer way, 5 mm at 4 mm/s, and the settling
  CHECK(bed.force.reads.back().records == 10);
  bed.press.move_xy(11.0, 3.0);
  CHECK(bed.clock.now() == milliseconds(1300 + 2000 + 50));
  bed.stage.put(Axis::kZ, std::nextafter(10.001, 11.0));
  check_press_fault([&] { bed.press.move_xy(0.0, 0.0); }, "TB-PRESS-NOT-CLEAR", {"10.001 mm", "10.000 mm"});
  CHECK(bed.stage.mm(Axis::kX) == 11.0);
  CHECK(fault_id_of([&] { (void)bed.press.tare(); }) == "TB-PRESS-NOT-CLEAR");
  CHECK(bed.force.biased_by == 0);
  bed.stage.put(Axis::kZ, 5.0);
  for (const double force_n : {0.5, -0.5, 2.0}) {
    bed.force.law = [=](double) { return force_n; };
    CHECK(fault_id_of([&] { bed.press.move_xy(0.0, 0.0); }) == "TB-PRESS-NOT-CLEAR");
  }
  CHECK(bed.stage.halts == 0);
  bed.force.law = [](double) { return std::nextafter(0.5, 0.0); };
  CHECK(fault_id_of([&] { bed.press.move_xy(0.0, 0.0); }) == "none");
  CHECK(bed.stage.halts == 0);
}

TEST_CASE("press on an ideal stage: an interrupted move in x and y halts the stage") {
  IdealBed bed(spring(20.0));
  bench::PressHooks hooks;
  hooks.wait = [](devices::Nanoseconds) { throw std::runtime_error("stop"); };
  Press press(bed.stage, bed.force, bed.clock, bed.options, hooks);
  CHECK_THROWS_WITH(press.move_xy(3.0, 3.0), "stop");
  CHECK(bed.stage.halts == 1);
  CHECK(bed.stage.mm(Axis::kX) == 0.0);
}

TEST_CASE("press on an ideal stage: a contact sets the clear position and is reported") {
  PressBed near(spring(20.0));
  CHECK(near.press.clear_z_mm() == 10.0);
  CHECK(near.press.approach().z_mm == Approx(12.0));
  CHECK(near.press.clear_z_mm() == 10.0);  // 11 mm would do
  REQUIRE(near.press.contact());
  CHECK(near.events.back().first == "contact");
  for (const char* number : {"12.0000 mm", "0.0150 mm", "20.0 N/mm", "0.40 N"})
    CHECK(near.events.back().second.find(number) != std::string::npos);
  bench::PressOptions wide = ideal_options();
  wide.clear_mm = 4.0;
  PressBed far(spring(20.0), wide);
  (void)far.press.approach();
  CHECK(far.press.clear_z_mm() == Approx(8.0));
  CHECK(far.press.retract().z_mm.value() == Approx(8.0));
  CHECK_FALSE(far.press.contact());
  CHECK(far.stage.speeds.back() == 4.0);
  far.press.home();
  CHECK(far.press.clear_z_mm() == 10.0);
  wide.clear_mm = 20.0;
  PressBed all(spring(20.0), wide);
  (void)all.press.approach();
  CHECK(all.press.clear_z_mm() == 0.0);
  CHECK(fault_id_of([&] {
          (void)near.press.retract();
          (void)near.go(2.0, Branch::kLoading, 0.0);
        }) == "TB-PRESS-NO-APPROACH");
}

TEST_CASE("press on an ideal stage: the reading of a level has times, means, spread and relaxation") {
  PressBed bed(spring(20.0));
  bed.force.spread_n = 0.07;
  (void)bed.press.tare();
  (void)bed.press.approach();
  // The specimen gives way by 0.3 N while the frame is read.
  bool framed = false;
  bed.force.law = [&](double z_mm) { return 20.0 * std::max(0.0, z_mm - 12.0) - (framed ? 0.3 : 0.0); };
  bed.on_frame = [&] { framed = true; };
  const devices::Nanoseconds begun = bed.clock.now();
  const PressReading first = bed.go(10.0, Branch::kLoading, 0.0);
  CHECK(first.commanded_at == begun);
  CHECK(first.in_band_since > begun);
  CHECK(first.start.time == first.in_band_since);
  CHECK(first.before.time == first.in_band_since);
  CHECK(first.after.time == first.before.time + milliseconds(30));
  const double level_n = first.start.force_n;
  CHECK(std::abs(level_n - 10.0) <= 0.1);
  CHECK(first.force_n == Approx(level_n - 0.15));
  CHECK(first.wrench.force_n[2] == Approx(-(level_n - 0.15)));
  CHECK(first.wrench.force_n[0] == Approx(0.25 * (level_n - 0.15)));
  CHECK(first.wrench.torque_nmm[2] == Approx(3.0 + level_n - 0.15));
  CHECK(first.spread_n == 0.07);  // its zero is no better than the tare
  CHECK(first.relaxation_n == 0.0);
  CHECK(first.z_mm == bed.stage.z_mm());
  CHECK(first.stiffness_n_per_mm == Approx(20.0));
  CHECK(first.moves > 0);
  CHECK(bed.frames == 1);
  framed = false;
  const std::size_t reads = bed.force.reads.size();
  const PressReading standing = bed.press.press({10.0, Branch::kLoading, 0.0, false}, nullptr);
  CHECK(standing.moves == 0);
  CHECK(standing.after.time == standing.before.time);
  CHECK(bed.force.reads.size() == reads + 2);  // reached, and before the frame that is not wanted
}

TEST_CASE("press on an ideal stage: during the dwell it reads each second, and corrects only if requested") {
  const bool hold = GENERATE(false, true);
  PressBed bed(spring(20.0));
  (void)bed.press.approach();
  const PressReading at_once = bed.go(10.0, Branch::kLoading, 0.0, hold);
  bed.force.reads.clear();
  bed.stage.sent_mm.clear();
  // Gives way by 0.04 N a second. Half of the tolerance is 0.05 N.
  const devices::Nanoseconds begun = bed.clock.now();
  bed.force.law = [&bed, begun](double z_mm) {
    return 20.0 * std::max(0.0, z_mm - 12.0) - 0.04 * devices::in_seconds(bed.clock.now() - begun);
  };
  const PressReading reading = bed.go(at_once.force_n, Branch::kLoading, 3.5, hold);
  REQUIRE_FALSE(reading.broken);
  CHECK(reading.in_band_since == begun);
  if (hold) {
    CHECK(bed.stage.sent_mm.size() == static_cast<std::size_t>(reading.moves));
    CHECK(reading.moves >= 1);
    CHECK(bed.clock.now() >= begun + milliseconds(3530));
    CHECK(std::abs(reading.before.force_n - at_once.force_n) <= 0.0501);
  } else {
    CHECK(reading.moves == 0);
    CHECK(bed.stage.sent_mm.empty());
    REQUIRE(bed.force.reads.size() == 1 + 3 + 1 + 1);
    for (int i = 1; i <= 3; ++i)
      CHECK(bed.force.reads[static_cast<std::size_t>(i)].time == begun + milliseconds(1000 * i));
    CHECK(reading.before.time == begun + milliseconds(3500));
    CHECK(reading.relaxation_n == Approx(0.14));
  }
}

TEST_CASE("press on an ideal stage: a held force is corrected from half its tolerance on, only in branch direction") {
  const auto [branch, drop_n, moves] = GENERATE(table<Branch, double, bool>({{Branch::kLoading, 0.049, false},
                                                                             {Branch::kLoading, 0.051, true},
                                                                             {Branch::kLoading, -0.06, false},
                                                                             {Branch::kUnloading, -0.049, false},
                                                                             {Branch::kUnloading, -0.051, true},
                                                                             {Branch::kUnloading, 0.06, false}}));
  PressBed bed(spring(20.0));
  (void)bed.press.approach();
  if (branch == Branch::kUnloading) (void)bed.go(20.0, Branch::kLoading, 0.0);
  const double there_n = bed.go(10.0, branch, 0.0).force_n;
  int looks = 0;
  bed.force.law = [&looks, drop_n = drop_n](double z_mm) {
    return 20.0 * std::max(0.0, z_mm - 12.0) - (++looks > 1 ? drop_n : 0.0);
  };
  const PressReading reading = bed.go(there_n, branch, 0.0, true);
  INFO((branch == Branch::kLoading ? "loading " : "unloading ") << drop_n);
  CHECK_FALSE(reading.broken);
  CHECK((reading.moves > 0) == moves);
}

TEST_CASE("press on an ideal stage: passing the level during the dwell breaks the branch without a frame") {
  PressBed bed(spring(20.0));
  (void)bed.press.approach();
  const double there_n = bed.go(10.0, Branch::kLoading, 0.0).force_n;
  // Slips by 0.06 N, and any further step meets a wall.
  int looks = 0;
  const double stands_mm = bed.stage.z_mm();
  bed.force.law = [&](double z_mm) {
    const double pressed = 20.0 * std::max(0.0, z_mm - 12.0);
    return z_mm > stands_mm ? pressed + 2.0 : pressed - (++looks > 1 ? 0.06 : 0.0);
  };
  bed.frames = 0;
  const PressReading reading = bed.go(there_n, Branch::kLoading, 2.0, true);
  REQUIRE(reading.broken);
  CHECK(bed.frames == 0);
  CHECK(reading.force_n == 0.0);
  CHECK(bed.events.back().first == "branch-broken");
}

// Refusals of a press plan before any motion: each limit at its edge and beyond it.

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

// Registration of the stage to the taxels from frames made here: the given transform is found, and ambiguous touches
// are refused.

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
