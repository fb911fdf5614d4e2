// What the guard takes from a bench file: its limits, and how old a reading may be at another rate of time.
#include <catch2/catch.hpp>

#include "bench/guard/guard.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("guard limits: a reading ages as fast as time runs, and no slower than in real time") {
  BenchConfig config;
  config.limits.stale_s = 0.8;
  config.limits.command_psi = 55.0;
  config.limits.force_n = {4.0, 6.0, 30.0};
  CHECK(guard_limits(config).safety.stale_s == 0.8);
  config.rate = 20.0;
  CHECK(guard_limits(config).safety.stale_s == Approx(16.0));
  config.rate = 0.25;
  CHECK(guard_limits(config).safety.stale_s == 0.8);
  CHECK(guard_limits(config).safety.command_psi == 55.0);
  CHECK(guard_limits(config).safety.force_n == std::array<double, 3>{4.0, 6.0, 30.0});
}

TEST_CASE("guard limits: z presses only under a force where there is a force sensor, axes have the stage's limits") {
  BenchConfig config;
  CHECK_FALSE(guard_limits(config).has_force);
  CHECK(guard_limits(config).axes[2].high_mm == 0.0);  // no stage, no way
  config.force.emplace();
  config.stage.emplace();
  devices::ZaberAxisOptions& z = config.stage->options.axes[2];
  z.low = devices::Millimetres(1.5);
  z.high = devices::Millimetres(42.0);
  z.maximum_speed = devices::MillimetresPerSecond(7.0);
  config.stage->options.axes[0].high = devices::Millimetres(58.0);
  const GuardLimits limits = guard_limits(config);
  CHECK(limits.has_force);
  CHECK((limits.axes[2].low_mm == 1.5 && limits.axes[2].high_mm == 42.0 && limits.axes[2].speed_mm_per_s == 7.0));
  CHECK(limits.axes[0].high_mm == 58.0);
}
