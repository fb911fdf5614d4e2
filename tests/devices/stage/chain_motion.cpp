// Motion of the simulated device by the clock: when and where it is, what it reports meanwhile, how an axis sticks.

#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <vector>

#include "devices/stage/motion_profile.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using enum ZaberCommand;

namespace {

constexpr double kLaStep = 0.00635 / 64;

// At home; moves at 4800 x 9.375 = 45000 steps/s and 4 x 11250 = 45000 steps/s^2: a ramp takes 1 s and 22500 steps.
struct EvenBench : ChainBench {
  EvenBench() {
    home();
    send(kTargetSpeed, 4800);
    send(kHomeSpeed, 4800);
    send(kAcceleration, 4);
  }
  // In steps, at a time after `begin`.
  double place(Nanoseconds time) { return device.position(time).value() / kLaStep; }
};

}  // namespace

TEST_CASE("simulated Zaber device: a move follows its ramps and ends at its computed time") {
  EvenBench bench;
  const Nanoseconds begin = bench.now;
  CHECK_FALSE(bench.device.due().has_value());
  bench.send(kMoveAbsolute, 90000);
  CHECK(bench.device.due() == begin + 3s);
  CHECK(bench.pass(1s).empty());
  CHECK(bench.read(kPosition) == 22500);
  CHECK(bench.pass(500ms).empty());
  CHECK(bench.read(kPosition) == 45000);
  bench.ends_after(1500ms, {1, kMoveAbsolute, 90000, 5});
  CHECK_FALSE(bench.device.due().has_value());
  CHECK(bench.place(begin + 500ms) == Approx(5625));
  CHECK(bench.place(begin + 2500ms) == Approx(84375));
  CHECK(bench.place(begin - 1s) == Approx(0.0).margin(1e-9));
  bench.send(kMoveRelative, -90000);
  CHECK(bench.device.due() == begin + 6s);
  bench.pass(1s);
  CHECK(bench.read(kPosition) == 67500);
}

TEST_CASE("simulated Zaber device: an acceleration of 0 is the highest acceleration") {
  EvenBench bench;
  const std::int32_t resolution = GENERATE(64, 32);
  bench.send(kResolution, resolution);
  bench.send(kAcceleration, 0);
  bench.send(kMoveAbsolute, 45000);
  // One second at its speed, and a ramp of 45000 / (11250 x 32767 or 16383) s.
  const Nanoseconds ramp = resolution == 64 ? 122074ns : 244156ns;
  REQUIRE(bench.device.due().has_value());
  CHECK(*bench.device.due() - bench.now - 1s - ramp >= 0ns);
  CHECK(*bench.device.due() - bench.now - 1s - ramp <= 2ns);
}

TEST_CASE("simulated Zaber device: a speed setting of 0 is the lowest speed") {
  EvenBench bench;
  bench.send(kTargetSpeed, GENERATE(0, 1));
  bench.send(kHomeSpeed, GENERATE(0, 1));
  for (const auto& [command, data] : {std::pair(kMoveAbsolute, 75), std::pair(kHome, 0)}) {
    bench.send(command, data);
    REQUIRE(bench.device.due().has_value());
    // 75 steps at 9.375 per second, and ramps of 0.2 ms.
    CHECK(*bench.device.due() - bench.now >= 8s);
    CHECK(*bench.device.due() - bench.now <= 8001ms);
    bench.pass(9s);
  }
}

TEST_CASE("simulated Zaber device: constant speed has its own value to either end, and is answered at once") {
  EvenBench bench;
  bench.send(kTargetSpeed, 100);
  bench.send(kMaximumPosition, 90000);
  CHECK(bench.send(kConstantSpeed, 4800) == std::vector<ZaberFrame>{{1, kConstantSpeed, 4800, 5}});
  CHECK(bench.device.due() == bench.now + 3s);
  bench.ends_after(3s, {1, kLimitActive, 90000, 0});
  CHECK(bench.send(kConstantSpeed, -4800) == std::vector<ZaberFrame>{{1, kConstantSpeed, -4800, 5}});
  CHECK(bench.device.due() == bench.now + 3s);
  bench.pass(1500ms);
  CHECK(bench.read(kPosition) == 45000);
  CHECK(bench.send(kConstantSpeed, 0) == std::vector<ZaberFrame>{{1, kConstantSpeed, 0, 5}});
  CHECK(bench.device.due() == bench.now + 1s);
  bench.pass(1s);
  CHECK(bench.read(kPosition) == 22500);
  CHECK(bench.read(kStatus) == 0);
  bench.send(kConstantSpeed, 1);
  CHECK(bench.pass(8s).empty());
  CHECK(bench.read(kPosition) == 22575);  // 9.375 a second
  bench.send(kConstantSpeed, -1);
  bench.pass(8s);
  CHECK(bench.read(kPosition) == 22500);
}

TEST_CASE(
    "simulated Zaber device: a stop uses the set acceleration, a relative move starts from the present position") {
  EvenBench bench;
  bench.send(kMoveAbsolute, 500000);
  bench.pass(2s);
  CHECK(bench.read(kPosition) == 67500);
  bench.send(kStop, 0);
  CHECK(bench.device.due() == bench.now + 1s);
  CHECK(bench.pass(1s) == std::vector<ZaberFrame>{{1, kStop, 90000, 5}});
  bench.send(kMoveAbsolute, 500000);
  bench.pass(1s);
  bench.send(kMoveRelative, 45000);  // from 112500: 22500 at its speed, 22500 to rest
  CHECK(bench.device.due() == bench.now + 1500ms);
  CHECK(bench.pass(1500ms) == std::vector<ZaberFrame>{{1, kMoveRelative, 157500, 5}});
}

TEST_CASE("simulated Zaber device: homing ends at its sensor or its home offset, where the counter is 0") {
  EvenBench bench;
  bench.go_to(90000);
  bench.send(kSetPosition, 1000);
  bench.send(kMode, 0);
  bench.send(kHome, 0);
  CHECK(bench.device.due() == bench.now + 3s);
  CHECK(bench.pass(3s - 1ns).empty());
  CHECK(bench.setting(kMode) == 0);
  CHECK(bench.pass(1ns) == std::vector<ZaberFrame>{{1, kHome, 0, 5}});
  CHECK(bench.setting(kMode) == kZaberHomed);
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
  bench.send(kHomeOffset, 100);
  bench.moves(kHome, 0, 0);
  CHECK(bench.place(bench.now) == Approx(100.0));
  // Homing from a motion begins with this motion.
  bench.send(kMoveAbsolute, 500000);
  bench.pass(1s);
  bench.send(kHome, 0);
  bench.pass(1s);
  CHECK(bench.place(bench.now) == Approx(100.0 + 22500 + 22500));
}

TEST_CASE("simulated Zaber device: with move tracking it reports its position every 0.25 s until the move ends") {
  EvenBench bench;
  bench.send(kMode, kZaberMoveTracking | kZaberHomed);
  bench.send(kMoveAbsolute, 90000);
  const Nanoseconds begin = bench.now;
  bench.ends_after(250ms, {1, kMoveTracking, 1406, 0});
  CHECK(bench.device.due() == begin + 500ms);
  CHECK(bench.pass(500ms) == std::vector<ZaberFrame>{{1, kMoveTracking, 5625, 0}, {1, kMoveTracking, 12656, 0}});
  const auto rest = bench.pass(10s);
  REQUIRE(rest.size() == 10);
  CHECK(rest[0] == ZaberFrame{1, kMoveTracking, 22500, 0});
  CHECK(rest[8] == ZaberFrame{1, kMoveTracking, 90000, 0});
  CHECK(rest[9] == ZaberFrame{1, kMoveAbsolute, 90000, 5});
  CHECK(bench.pass(10s).empty());
  // 0.4 s: the end comes before the second report.
  bench.send(kMoveRelative, 1800);
  CHECK(bench.pass(250ms).size() == 1);
  CHECK(bench.device.due() == bench.now + 150ms);
  CHECK(bench.pass(10s) == std::vector<ZaberFrame>{{1, kMoveRelative, 91800, 5}});
}

TEST_CASE("simulated Zaber device: is at rest from the end of its motion on") {
  EvenBench bench;
  ChainBench fresh;
  CHECK(fresh.device.at_rest_since(0ns));
  fresh.device.free(5s);  // it does not stick
  CHECK(fresh.device.at_rest_since(0ns));
  const Nanoseconds begin = bench.now;
  CHECK(bench.device.at_rest_since(begin));
  bench.send(kMoveAbsolute, 90000);
  CHECK_FALSE(bench.device.at_rest_since(begin - 1ns));
  CHECK_FALSE(bench.device.at_rest_since(begin));
  CHECK_FALSE(bench.device.at_rest_since(begin + 3s - 1ns));
  CHECK(bench.device.at_rest_since(begin + 3s));
  bench.pass(1s);
  bench.device.stick(bench.now);
  CHECK_FALSE(bench.device.at_rest_since(bench.now - 1ns));
  CHECK(bench.device.at_rest_since(bench.now));
}

TEST_CASE(
    "simulated Zaber device: a stuck axis stays while the counter advances, and continues from there when freed") {
  EvenBench bench;
  const Nanoseconds begin = bench.now;
  bench.send(kMoveAbsolute, 90000);
  bench.pass(1s);
  bench.device.stick(bench.now);
  bench.pass(500ms);
  CHECK(bench.read(kPosition) == 45000);
  CHECK(bench.place(bench.now) == Approx(22500));
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(22500));
  CHECK(bench.pass(1500ms) == std::vector<ZaberFrame>{{1, kMoveAbsolute, 90000, 5}});
  CHECK(bench.place(bench.now) == Approx(67500));
  CHECK(bench.place(begin + 500ms) == Approx(5625));
  CHECK(bench.place(begin + 1200ms) == Approx(22500));
  CHECK(bench.place(begin + 2s) == Approx(45000));
  // Missed steps add to those missed before.
  bench.device.stick(bench.now);
  CHECK(bench.place(bench.now) == Approx(67500));
  bench.go_to(0);
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(67500));
  bench.send(kHome, 0);
  CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kHome, 0, 5}});
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
}

TEST_CASE("simulated Zaber device: homing of a stuck axis ends only after it is freed") {
  EvenBench bench;
  bench.go_to(90000);
  bench.device.stick(bench.now);
  bench.send(kHome, 0);
  CHECK(bench.pass(1h).empty());
  CHECK(bench.read(kStatus) == 1);
  CHECK(bench.place(bench.now) == Approx(90000));
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(90000));
  CHECK(bench.device.due() == bench.now + 3s);
  bench.ends_after(3s, {1, kHome, 0, 5});
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
  CHECK(bench.read(kPosition) == 0);
  // Other moves of an axis that sticks end as if it moved.
  bench.device.stick(bench.now);
  bench.send(kMoveAbsolute, 90000);
  CHECK(bench.pass(3s) == std::vector<ZaberFrame>{{1, kMoveAbsolute, 90000, 5}});
  bench.device.free(bench.now);
  CHECK_FALSE(bench.device.due().has_value());
}

TEST_CASE("simulated Zaber device: remembers its last 256 changes of motion, and the position before them") {
  ChainBench bench;
  bench.home();  // the first change
  const double homing = bench.device.position(1s).value() / kLaStep;
  CHECK(homing > 10000);
  const auto middle_of = [&](std::int32_t target) {
    bench.send(kMoveAbsolute, target);
    bench.pass(10s);
    return bench.now - 5s;  // it is at rest there by then
  };
  const Nanoseconds first = middle_of(5000);
  const Nanoseconds second = middle_of(1000);
  for (std::int32_t i = 3; i < 256; ++i) middle_of(1000 + i);
  const auto steps_at = [&](Nanoseconds time) { return bench.device.position(time).value() / kLaStep; };
  CHECK(steps_at(1s) == Approx(homing));
  middle_of(2000);  // the 257th change, then the 258th: the motion to its home is forgotten
  CHECK(steps_at(1s) == Approx(homing));
  middle_of(3000);
  CHECK(steps_at(1s) == Approx(0.0).margin(1e-9));
  CHECK(steps_at(30s) == Approx(0.0).margin(1e-9));
  CHECK(steps_at(first) == Approx(5000));
  middle_of(2000);
  CHECK(steps_at(first) == Approx(5000));
  CHECK(steps_at(30s) == Approx(5000));
  CHECK(steps_at(second) == Approx(1000));
}

// Motions of one simulated axis by constant acceleration, worked out by hand.

namespace {

struct MotionAt {
  double time, position, velocity;
};

void check_motion(const MotionProfile& profile, double duration, const std::vector<MotionAt>& points) {
  CHECK(profile.duration() == Approx(duration).margin(1e-12));
  for (const MotionAt& point : points) {
    INFO("after " << point.time << " s");
    CHECK(profile.position(point.time) == Approx(point.position).margin(1e-12));
    CHECK(profile.velocity(point.time) == Approx(point.velocity).margin(1e-12));
  }
}

}  // namespace

TEST_CASE("motion profile: an axis at rest keeps its position") {
  const MotionProfile stands(3.0);
  CHECK(stands.end() == 3.0);
  check_motion(stands, 0.0, {{-1.0, 3.0, 0.0}, {0.0, 3.0, 0.0}, {5.0, 3.0, 0.0}});
  const MotionProfile there = MotionProfile::to(3.0, 0.0, 3.0, 2.0, 1.0);
  CHECK(there.end() == 3.0);
  check_motion(there, 0.0, {{-1.0, 3.0, 0.0}, {0.0, 3.0, 0.0}, {5.0, 3.0, 0.0}});
  CHECK(MotionProfile().end() == 0.0);
}

TEST_CASE("motion profile: follows ramps calculated from its equations, in both directions") {
  struct Motion {
    double from, velocity, target, speed, acceleration, duration;
    std::vector<MotionAt> points;
  };
  const double t = 0.015625;
  const std::vector<Motion> motions{
      // 2 s at 1/s^2 to a speed of 2 over a distance of 2, the same at the end, 6 at a speed of 2 between.
      {100,
       0,
       110,
       2,
       1,
       7,
       {{-1, 100, 0},
        {0, 100, 0},
        {1, 100.5, 1},
        {2, 102, 2},
        {3.5, 105, 2},
        {5, 108, 2},
        {6, 109.5, 1},
        {7, 110, 0},
        {9, 110, 0}}},
      // Short ones never reach their speed. A distance of 1/64 at 1/s^2: 1/8 s up, 1/8 s down.
      {0, 0, 4, 10, 1, 4, {{1, 0.5, 1}, {2, 2, 2}, {3, 3.5, 1}}},
      {0, 0, 0.015625, 10, 1, 0.25, {{0.0625, 0.001953125, 0.0625}, {0.125, 0.0078125, 0.125}, {0.25, 0.015625, 0}}},
      // Of milliseconds: 1/64 s at 128/s^2 to a speed of 2 over 1/64, as long at this speed over 2/64, and 1/64 to
      // rest.
      {0,
       0,
       4 * t,
       2,
       128,
       3 * t,
       {{t / 2, t / 4, 1}, {t, t, 2}, {1.5 * t, 2 * t, 2}, {2 * t, 3 * t, 2}, {2.5 * t, 3.75 * t, 1}}},
      // A start above the set speed: from 4 to 2 in 2 s over 6, 12 at 2 in 6 s, then 2 s over 2 to rest.
      {0, 4, 20, 2, 1, 10, {{0, 0, 4}, {1, 3.5, 3}, {2, 6, 2}, {5, 12, 2}, {8, 18, 2}, {9, 19.5, 1}}},
      // Already on its way: v^2 = d + v0^2 / 2 = 7/32 + 1/32, so that it speeds up from 1/4 to 1/2 and down to rest.
      {0, 0.25, 0.21875, 10, 1, 0.75, {{0.25, 0.09375, 0.5}, {0.5, 0.1875, 0.25}}},
      // It needs all of the distance to slow down.
      {0, 4, 8, 10, 1, 4, {{1, 3.5, 3}, {2, 6, 2}, {3, 7.5, 1}}},
      // Away from its target: from 0 at -2 to rest at -2 in 2 s, then 4 to the target at 2: 2 s up to 2, 2 s down.
      {0, -2, 2, 10, 1, 6, {{0, 0, -2}, {1, -1.5, -1}, {2, -2, 0}, {4, 0, 2}, {5, 1.5, 1}, {6, 2, 0}}},
      // Slowly away: 1/16 s to rest 1/512 behind, then 1/64 - 1/512 in front of it.
      {0, -0.0625, 0.029296875, 10, 1, 0.0625 + 2 * 0.176776695296637, {{0.0625, -0.001953125, 0}}},
      // Too fast to stop at its target: from 4 to rest at 8 in 4 s, then back over 4: 2 s up to 2, 2 s down.
      {0, 4, 4, 10, 1, 8, {{0, 0, 4}, {2, 6, 2}, {4, 8, 0}, {6, 6, -2}, {7, 4.5, -1}, {8, 4, 0}}},
      // At its target and moving: to rest 8 beyond it in 4 s, back with at most 2: 2 s over 2, 2 s over 4, 2 s.
      {0, 4, 0, 2, 1, 10, {{4, 8, 0}, {6, 6, -2}, {8, 2, -2}, {9, 0.5, -1}}}};
  for (const Motion& one : motions) {
    for (const double way : {1.0, -1.0}) {
      CAPTURE(way, one.from, one.velocity, one.target);
      const MotionProfile profile =
          MotionProfile::to(way * one.from, way * one.velocity, way * one.target, one.speed, one.acceleration);
      CHECK(profile.end() == way * one.target);
      std::vector<MotionAt> points = one.points;
      for (MotionAt& point : points) point = {point.time, way * point.position, way * point.velocity};
      check_motion(profile, one.duration, points);
    }
  }
}

TEST_CASE("motion profile: a motion brought to rest ends at its stopping distance, in both directions") {
  const double way = GENERATE(1.0, -1.0);
  const MotionProfile fast = MotionProfile::to_rest(10.0, way * 4.0, 2.0);
  CHECK(fast.end() == 10.0 + way * 4.0);
  check_motion(fast, 2.0,
               {{-1.0, 10.0, way * 4.0},
                {0.0, 10.0, way * 4.0},
                {1.0, 10.0 + way * 3.0, way * 2.0},
                {2.0, 10.0 + way * 4.0, 0.0},
                {3.0, 10.0 + way * 4.0, 0.0}});
  const MotionProfile slow = MotionProfile::to_rest(0.0, way * 0.0625, 1.0);
  check_motion(slow, 0.0625, {{0.03125, way * 0.00146484375, way * 0.03125}, {0.0625, way * 0.001953125, 0.0}});
  const MotionProfile stands = MotionProfile::to_rest(5.0, 0.0, 2.0);
  CHECK(stands.end() == 5.0);
  check_motion(stands, 0.0, {{0.0, 5.0, 0.0}, {1.0, 5.0, 0.0}});
}

TEST_CASE("motion profile: is continuous, never exceeds its speed and ends at rest at its target") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-100.0, 100.0);
  std::uniform_real_distribution<double> pace(-10.0, 10.0);
  std::uniform_real_distribution<double> positive(0.5, 20.0);
  for (int i = 0; i < 500; ++i) {
    const double from = place(random);
    const double velocity = pace(random);
    const double target = place(random);
    const double speed = positive(random);
    const double acceleration = positive(random);
    const MotionProfile profile = MotionProfile::to(from, velocity, target, speed, acceleration);
    const double step = profile.duration() / 400;
    const double bound = std::max(std::abs(velocity), speed) + 1e-9;
    REQUIRE(profile.position(0.0) == Approx(from).margin(1e-9));
    for (int k = 0; k < 400; ++k) {
      REQUIRE(std::abs(profile.velocity(k * step)) <= bound);
      REQUIRE(std::abs(profile.position((k + 1) * step) - profile.position(k * step)) <= bound * step + 1e-6);
    }
    REQUIRE(profile.position(profile.duration()) == target);
    REQUIRE(profile.velocity(profile.duration()) == 0.0);
    const MotionProfile rest = MotionProfile::to_rest(from, velocity, acceleration);
    REQUIRE(rest.position(rest.duration() * (1 - 1e-9)) == Approx(rest.end()).margin(1e-6));
  }
}
