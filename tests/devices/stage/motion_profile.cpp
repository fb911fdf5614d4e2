// Motions of one simulated axis by constant acceleration, worked out by hand.
#include "devices/stage/motion_profile.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace tactbench::devices;

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

TEST_CASE("motion profile: a long motion accelerates, keeps its speed and decelerates, in both directions") {
  // 2 s at 1/s^2 to a speed of 2 over a distance of 2, the same at the end, 6 at a speed of 2 between.
  const double way = GENERATE(1.0, -1.0);
  const MotionProfile profile = MotionProfile::to(100.0, 0.0, 100.0 + way * 10.0, 2.0, 1.0);
  CHECK(profile.end() == 100.0 + way * 10.0);
  std::vector<MotionAt> points{{-1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {1.0, 0.5, 1.0},  {2.0, 2.0, 2.0}, {3.5, 5.0, 2.0},
                               {5.0, 8.0, 2.0},  {6.0, 9.5, 1.0}, {7.0, 10.0, 0.0}, {9.0, 10.0, 0.0}};
  for (MotionAt& point : points) point = {point.time, 100.0 + way * point.position, way * point.velocity};
  check_motion(profile, 7.0, points);
}

TEST_CASE("motion profile: a short motion decelerates before it reaches its speed") {
  check_motion(MotionProfile::to(0.0, 0.0, 4.0, 10.0, 1.0), 4.0, {{1.0, 0.5, 1.0}, {2.0, 2.0, 2.0}, {3.0, 3.5, 1.0}});
  // A distance of 1/64 at 1/s^2: 1/8 s up, 1/8 s down.
  check_motion(MotionProfile::to(0.0, 0.0, 0.015625, 10.0, 1.0), 0.25,
               {{0.0625, 0.001953125, 0.0625}, {0.125, 0.0078125, 0.125}, {0.25, 0.015625, 0.0}});
}

TEST_CASE("motion profile: a motion of milliseconds has all three phases") {
  // 1/64 s at 128/s^2 to a speed of 2 over 1/64, as long at this speed over 2/64, and 1/64 to rest.
  const double t = 0.015625;
  check_motion(
      MotionProfile::to(0.0, 0.0, 4 * t, 2.0, 128.0), 3 * t,
      {{t / 2, t / 4, 1.0}, {t, t, 2.0}, {1.5 * t, 2 * t, 2.0}, {2 * t, 3 * t, 2.0}, {2.5 * t, 3.75 * t, 1.0}});
}

TEST_CASE("motion profile: a start above the set speed decelerates to it first, in both directions") {
  // From 4 to 2 in 2 s over 6, 12 at 2 in 6 s, then 2 s over 2 to rest.
  const double way = GENERATE(1.0, -1.0);
  std::vector<MotionAt> points{{0.0, 0.0, 4.0},  {1.0, 3.5, 3.0},  {2.0, 6.0, 2.0},
                               {5.0, 12.0, 2.0}, {8.0, 18.0, 2.0}, {9.0, 19.5, 1.0}};
  for (MotionAt& point : points) point = {point.time, way * point.position, way * point.velocity};
  check_motion(MotionProfile::to(0.0, way * 4.0, way * 20.0, 2.0, 1.0), 10.0, points);
}

TEST_CASE("motion profile: a motion already towards its target continues without a stop") {
  // v^2 = d + v0^2 / 2 = 7/32 + 1/32, so that it speeds up from 1/4 to 1/2 and down to rest.
  check_motion(MotionProfile::to(0.0, 0.25, 0.21875, 10.0, 1.0), 0.75, {{0.25, 0.09375, 0.5}, {0.5, 0.1875, 0.25}});
  // It needs all of the distance to slow down.
  check_motion(MotionProfile::to(0.0, 4.0, 8.0, 10.0, 1.0), 4.0, {{1.0, 3.5, 3.0}, {2.0, 6.0, 2.0}, {3.0, 7.5, 1.0}});
}

TEST_CASE("motion profile: a motion away from its target stops and returns, in both directions") {
  // From 0 at -2 to rest at -2 in 2 s, then 4 to the target at 2: 2 s up to 2, 2 s down.
  const double way = GENERATE(1.0, -1.0);
  std::vector<MotionAt> points{{0.0, 0.0, -2.0}, {1.0, -1.5, -1.0}, {2.0, -2.0, 0.0},
                               {4.0, 0.0, 2.0},  {5.0, 1.5, 1.0},   {6.0, 2.0, 0.0}};
  for (MotionAt& point : points) point = {point.time, way * point.position, way * point.velocity};
  check_motion(MotionProfile::to(0.0, way * -2.0, way * 2.0, 10.0, 1.0), 6.0, points);
  // Slowly away: 1/16 s to rest 1/512 behind, then 1/64 - 1/512 in front of it.
  check_motion(MotionProfile::to(0.0, way * -0.0625, way * 0.029296875, 10.0, 1.0), 0.0625 + 2 * 0.176776695296637,
               {{0.0625, way * -0.001953125, 0.0}});
}

TEST_CASE("motion profile: a motion too fast to stop at its target overshoots and returns, in both directions") {
  // From 4 to rest at 8 in 4 s, then back over 4: 2 s up to 2, 2 s down.
  const double way = GENERATE(1.0, -1.0);
  std::vector<MotionAt> points{{0.0, 0.0, 4.0},  {2.0, 6.0, 2.0},  {4.0, 8.0, 0.0},
                               {6.0, 6.0, -2.0}, {7.0, 4.5, -1.0}, {8.0, 4.0, 0.0}};
  for (MotionAt& point : points) point = {point.time, way * point.position, way * point.velocity};
  check_motion(MotionProfile::to(0.0, way * 4.0, way * 4.0, 10.0, 1.0), 8.0, points);
  // It is at its target and still moves: to rest 8 beyond it in 4 s, back with at most 2: 2 s over 2, 2 s over 4, 2 s.
  points = {{4.0, 8.0, 0.0}, {6.0, 6.0, -2.0}, {8.0, 2.0, -2.0}, {9.0, 0.5, -1.0}};
  for (MotionAt& point : points) point = {point.time, way * point.position, way * point.velocity};
  check_motion(MotionProfile::to(0.0, way * 4.0, 0.0, 2.0, 1.0), 10.0, points);
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
