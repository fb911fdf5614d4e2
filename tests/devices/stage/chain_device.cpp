// The simulated device without a wire: answers, errors and motion as in the manual of firmware 5.
#include "tests/devices/stage/chain_bench.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("a chain device reports its identity and its position") {
  ChainBench bench;
  CHECK(bench.send(kDeviceId, 0) == std::vector<ZaberFrame>{{1, kDeviceId, 60, 5}});
  CHECK(bench.send(kFirmware, 0) == std::vector<ZaberFrame>{{1, kFirmware, 523, 5}});
  CHECK(bench.send(kSupplyVoltage, 0) == std::vector<ZaberFrame>{{1, kSupplyVoltage, 150, 5}});
  CHECK(bench.send(kEcho, -77) == std::vector<ZaberFrame>{{1, kEcho, -77, 5}});
  CHECK(bench.send(kStatus, 0) == std::vector<ZaberFrame>{{1, kStatus, 0, 5}});
  CHECK(bench.send(kReturnSetting, 44) == std::vector<ZaberFrame>{{1, kMaximumPosition, 604724, 5}});
  CHECK(bench.send(kEcho, 1, 2).empty());
  // 5 mm, to the nearest step.
  CHECK(bench.device.position(0ns).value() == Approx(50394 * 0.00635 / 64).epsilon(1e-12));
}

TEST_CASE("a chain device refuses with the manual's error numbers") {
  ChainBench bench;
  CHECK(bench.error_of(static_cast<ZaberCommand>(99), 0) == 64);
  CHECK(bench.error_of(kReturnSetting, 99) == 53);
  CHECK(bench.error_of(kRenumber, 255) == 2);
  CHECK(bench.error_of(kStorePosition, 16) == 1600);
  CHECK(bench.error_of(kStorePosition, 0) == 1601);
  CHECK(bench.error_of(kReturnStoredPosition, 16) == 1700);
  CHECK(bench.error_of(kMoveToStoredPosition, 16) == 1800);
  CHECK(bench.error_of(kMoveToStoredPosition, 0) == 1801);
  bench.home();
  CHECK(bench.error_of(kMoveAbsolute, -1) == 20);
  CHECK(bench.error_of(kMoveAbsolute, 604725) == 20);
  CHECK(bench.error_of(kMoveRelative, -1) == 21);
  CHECK(bench.error_of(kMoveRelative, 700000) == 2146);
  CHECK(bench.error_of(kConstantSpeed, 32768) == 22);
  CHECK(bench.error_of(kRestoreSettings, 1) == 36);
  CHECK(bench.error_of(kResolution, 3) == 37);
  CHECK(bench.error_of(kRunningCurrent, 9) == 38);
  CHECK(bench.error_of(kHoldCurrent, 128) == 39);
  CHECK(bench.error_of(kMode, 1 << 16) == 40);
  CHECK(bench.error_of(kMode, 1 << 8) == 4008);
  CHECK(bench.error_of(kMode, 1 << 10) == 4010);
  CHECK(bench.error_of(kMode, 1 << 13) == 4013);
  CHECK(bench.error_of(kHomeSpeed, 32768) == 41);
  CHECK(bench.error_of(kTargetSpeed, -1) == 42);
  CHECK(bench.error_of(kAcceleration, 32768) == 43);
  CHECK(bench.error_of(kMaximumPosition, -1) == 44);
  CHECK(bench.error_of(kSetPosition, 604725) == 45);
  CHECK(bench.error_of(kMaximumRelativeMove, -1) == 46);
  CHECK(bench.error_of(kHomeOffset, -1) == 47);
  CHECK(bench.error_of(kAlias, 255) == 48);
  CHECK(bench.error_of(kLock, 2) == 49);
  CHECK(bench.error_of(kLock, 1) == 0);
  CHECK(bench.error_of(kTargetSpeed, 100) == 3600);
  CHECK(bench.error_of(kLock, 0) == 0);
  CHECK(bench.error_of(kTargetSpeed, 100) == 0);
}

TEST_CASE("a move is answered when it ends, and of a replaced move only the replacement is answered") {
  ChainBench bench;
  bench.home();
  CHECK(bench.send(kMoveAbsolute, 100000).empty());
  CHECK(bench.pass(1s).empty());
  CHECK(bench.send(kStatus, 0)[0].data == 20);
  CHECK(bench.send(kMoveRelative, 1000).empty());
  const std::int32_t target = bench.send(kPosition, 0)[0].data + 1000;
  const auto ends = bench.pass(60s);
  REQUIRE(ends.size() == 1);
  CHECK(ends[0].command == kMoveRelative);
  CHECK(ends[0].data == target);
  CHECK(bench.pass(60s).empty());
}

TEST_CASE("constant speed is answered at once and its limit reported unasked") {
  ChainBench bench;
  bench.home();
  CHECK(bench.send(kConstantSpeed, 3000) == std::vector<ZaberFrame>{{1, kConstantSpeed, 3000, 5}});
  CHECK(bench.send(kStatus, 0)[0].data == 22);
  CHECK(bench.pass(300s) == std::vector<ZaberFrame>{{1, kLimitActive, 604724, 0}});
  CHECK(bench.send(kConstantSpeed, -3000).size() == 1);
  bench.pass(1s);
  CHECK(bench.send(kStop, 0).empty());
  const auto stopped = bench.pass(1s);
  REQUIRE(stopped.size() == 1);
  CHECK(stopped[0].command == kStop);
  CHECK(stopped[0].data < 604724);
  CHECK(stopped[0].data > 500000);
}

TEST_CASE("move tracking comes every quarter of a second when its mode bit is set") {
  ChainBench bench;
  bench.home();
  bench.send(kMode, kZaberMoveTracking | kZaberHomed);
  bench.send(kMoveAbsolute, 50000);
  CHECK(bench.device.due() == bench.now + 250ms);
  const auto said = bench.pass(1s);
  REQUIRE(said.size() == 4);
  for (const ZaberFrame& frame : said) {
    CHECK(frame.command == kMoveTracking);
    CHECK(frame.id == 0);
  }
}

TEST_CASE("without auto-reply a chain device answers queries only") {
  ChainBench bench;
  bench.send(kMode, kZaberNoAutoReply);
  CHECK(bench.send(kTargetSpeed, 100).empty());
  CHECK(bench.send(kReturnSetting, 42) == std::vector<ZaberFrame>{{1, kTargetSpeed, 100, 5}});
  CHECK(bench.send(kEcho, 3).size() == 1);
  bench.send(kHome, 0);
  CHECK(bench.pass(60s).empty());
}

TEST_CASE("reset loses home status and position but no setting, and an alias is accepted beside the own number") {
  ChainBench bench;
  bench.home();
  bench.send(kTargetSpeed, 123);
  bench.send(kAlias, 9);
  CHECK(bench.send(kEcho, 1, 9) == std::vector<ZaberFrame>{{1, kEcho, 1, 5}});
  bench.send(kMoveAbsolute, 1000);
  bench.pass(60s);
  bench.send(kReset, 0);
  CHECK(bench.send(kPosition, 0)[0].data == 0);
  CHECK((bench.send(kReturnSetting, 40)[0].data & kZaberHomed) == 0);
  CHECK(bench.send(kReturnSetting, 42)[0].data == 123);
  CHECK(bench.device.position(bench.now).value() == Approx(1000 * 0.00009921875));
}

TEST_CASE("stored positions, memory and set position keep the values written") {
  ChainBench bench;
  bench.home();
  bench.send(kMoveAbsolute, 4000);
  bench.pass(60s);
  CHECK(bench.send(kStorePosition, 3)[0].data == 3);
  CHECK(bench.send(kReturnStoredPosition, 3)[0].data == 4000);
  bench.send(kMoveAbsolute, 0);
  bench.pass(60s);
  bench.send(kMoveToStoredPosition, 3);
  CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kMoveToStoredPosition, 4000, 5}});
  bench.send(kMemory, 0x80 | 17 | 200 << 8);
  CHECK(bench.send(kMemory, 17)[0].data == (17 | 200 << 8));
  bench.send(kSetPosition, 70);
  CHECK(bench.send(kPosition, 0)[0].data == 70);
}

TEST_CASE("another resolution moves nothing, now and in what has passed, and counts in its own steps") {
  ChainBench bench;
  bench.home();
  bench.send(kMoveAbsolute, 100000);
  const Nanoseconds began = bench.now;
  bench.pass(60s);
  const auto at = [&](Nanoseconds time) { return bench.device.position(time).value(); };
  const double halfway = at(began + 1s), there = at(bench.now);
  CHECK(there == Approx(100000 * 0.00635 / 64));
  CHECK(halfway < 0.9 * there);
  CHECK(bench.send(kResolution, 128) == std::vector<ZaberFrame>{{1, kResolution, 128, 5}});
  CHECK(bench.send(kPosition, 0)[0].data == 200000);
  CHECK(at(bench.now) == Approx(there).epsilon(1e-12));
  CHECK(at(began + 1s) == halfway);
  bench.send(kMoveAbsolute, 100000);
  bench.pass(60s);
  CHECK(at(bench.now) == Approx(there / 2).epsilon(1e-12));
}

TEST_CASE("a motion never leaps, never exceeds its speed and ends at rest at its target") {
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
