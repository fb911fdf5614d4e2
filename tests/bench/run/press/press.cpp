// The press on an ideal stage: where it permits moves, what a level's reading contains, and when a branch breaks.
#include "bench/run/press/press.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "bench/config/config.h"
#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::Press;
using bench::PressReading;
using devices::Axis;
using devices::fault_id_of;
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
