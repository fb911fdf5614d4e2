// The settings of the simulated device: their values at first, each limit and its neighbours, what a change does.
#include <catch2/catch.hpp>
#include <string>

#include "tests/devices/stage/chain_bench.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("a new chain device has its model's settings and those of its options") {
  ChainBench bench;
  CHECK(bench.setting(kResolution) == 64);
  CHECK(bench.setting(kRunningCurrent) == 10);
  CHECK(bench.setting(kHoldCurrent) == 20);
  CHECK(bench.setting(kMode) == 0);
  CHECK(bench.setting(kHomeSpeed) == 2922);
  CHECK(bench.setting(kTargetSpeed) == 2922);
  CHECK(bench.setting(kAcceleration) == 111);
  CHECK(bench.setting(kMaximumPosition) == 604724);  // 60 mm in steps of 1.27 mm / 200 / 64
  CHECK(bench.setting(kMaximumRelativeMove) == 604724);
  CHECK(bench.setting(kHomeOffset) == 0);
  CHECK(bench.setting(kAlias) == 0);
  CHECK(bench.setting(kLock) == 0);
  CHECK(bench.setting(kSetPosition) == 0);  // it returns the position

  ChainDeviceOptions options;
  options.device_id = 5082;
  options.home_speed = 11;
  options.target_speed = 12;
  options.acceleration = 13;
  options.mode = kZaberHomed | kZaberKnobOff;
  ChainBench other(options);
  CHECK(other.setting(kMaximumPosition) == 1066666);  // 50.8 mm in steps of 0.6096 mm / 200 / 64
  CHECK(other.setting(kMaximumRelativeMove) == 1066666);
  CHECK(other.setting(kHomeSpeed) == 11);
  CHECK(other.setting(kTargetSpeed) == 12);
  CHECK(other.setting(kAcceleration) == 13);
  CHECK(other.setting(kMode) == kZaberKnobOff);  // no home after power-up

  options.device_id = 7;  // a model that is in no table has the units of the T-LA60A
  ChainBench unknown(options);
  CHECK(unknown.read(kDeviceId) == 7);
  CHECK(unknown.setting(kMaximumPosition) == 604724);
}

TEST_CASE("each setting of a chain device takes its lowest and highest value and refuses what is beyond them") {
  struct Limits {
    ZaberCommand setting;
    std::int32_t error;
    std::vector<std::int32_t> taken, refused;
  };
  const std::vector<Limits> table{
      {kResolution, 37, {1, 2, 4, 8, 16, 32, 128, 64}, {0, 3, 65, 127, 129, 256, -1, -64}},
      {kRunningCurrent, 38, {0, 10, 127}, {-1, 1, 9, 128}},
      {kHoldCurrent, 39, {0, 10, 127}, {-1, 1, 9, 128}},
      {kMode, 40, {0, 0xDAFE, 1 << 9, 1 << 15, 0}, {1 << 16, 1 << 20}},
      {kHomeSpeed, 41, {0, 1, 32767}, {-1, 32768}},
      {kTargetSpeed, 42, {0, 1, 32767}, {-1, 32768}},
      {kAcceleration, 43, {0, 1, 32767}, {-1, 32768}},
      {kMaximumRelativeMove, 46, {0, 16777215}, {-1, 16777216}},
      {kHomeOffset, 47, {0, 604724, 0}, {-1, 604725}},
      {kSetPosition, 45, {0, 604724, 0}, {-1, 604725}},
      {kMaximumPosition, 44, {0, 16777215}, {-1, 16777216}},
      {kAlias, 48, {0, 254}, {-1, 255}},
      {kLock, 49, {0, 1, 0}, {-1, 2}},
  };
  ChainBench bench;
  for (const Limits& one : table) {
    for (const std::int32_t value : one.taken) {
      INFO(name(one.setting) << " " << value);
      CHECK(bench.send(one.setting, value) == std::vector<ZaberFrame>{{1, one.setting, value, 5}});
      CHECK((bench.setting(one.setting) & ~kZaberHomed) == (value & ~kZaberHomed));
    }
    const std::int32_t before = bench.setting(one.setting);
    for (const std::int32_t value : one.refused) {
      INFO(name(one.setting) << " " << value);
      CHECK(bench.error_of(one.setting, value) == one.error);
      CHECK(bench.setting(one.setting) == before);
    }
  }
}

TEST_CASE("each reserved bit of a chain device's mode is refused by its own number, the lowest first") {
  ChainBench bench;
  CHECK(bench.error_of(kMode, 1 << 8 | 1 << 10) == 4008);
  CHECK(bench.error_of(kMode, 1 << 10 | 1 << 13) == 4010);
  CHECK(bench.error_of(kMode, 1 << 13 | 1 << 16) == 4013);
  CHECK(bench.error_of(kMode, -1) == 4008);
  CHECK(bench.setting(kMode) == 0);
}

TEST_CASE("limits of speeds and acceleration are those of the resolution") {
  ChainBench bench;
  bench.send(kResolution, 32);  // 512 * 32 - 1
  for (const auto& [setting, error] :
       {std::pair(kHomeSpeed, 41), std::pair(kTargetSpeed, 42), std::pair(kAcceleration, 43)}) {
    CHECK(bench.error_of(setting, 16383) == 0);
    CHECK(bench.error_of(setting, 16384) == error);
  }
  bench.home();
  CHECK(bench.error_of(kConstantSpeed, 16384) == 22);
  CHECK(bench.error_of(kConstantSpeed, 16383) == 0);
}

TEST_CASE("firmware before 5.23 refuses a maximum below the present position") {
  const auto [firmware, refuses] = GENERATE(table<std::int32_t, bool>({{521, true}, {522, true}, {523, false}}));
  ChainDeviceOptions options;
  options.firmware = firmware;
  ChainBench bench(options);
  bench.home();
  bench.go_to(1000);
  CHECK(bench.error_of(kMaximumPosition, 999) == (refuses ? 44 : 0));
  CHECK(bench.error_of(kMaximumPosition, 1000) == 0);
  CHECK(bench.setting(kMaximumPosition) == 1000);
  CHECK(bench.error_of(kMaximumPosition, 1001) == 0);
}

TEST_CASE("locked settings of a chain device change in nothing but the lock") {
  ChainBench bench;
  bench.send(kLock, 1);
  for (const ZaberCommand setting :
       {kResolution, kRunningCurrent, kHoldCurrent, kMode, kHomeSpeed, kTargetSpeed, kAcceleration, kMaximumPosition,
        kMaximumRelativeMove, kSetPosition, kHomeOffset, kAlias}) {
    INFO(name(setting));
    const std::int32_t before = bench.setting(setting);
    CHECK(bench.error_of(setting, 16) == 3600);
    CHECK(bench.setting(setting) == before);
  }
  CHECK(bench.send(kLock, 1) == std::vector<ZaberFrame>{{1, kLock, 1, 5}});
  CHECK(bench.send(kLock, 0) == std::vector<ZaberFrame>{{1, kLock, 0, 5}});
  CHECK(bench.error_of(kAlias, 16) == 0);
}

TEST_CASE("the resolution of a chain device that moves is not changed") {
  ChainBench bench;
  bench.send(kHome, 0);
  CHECK(bench.error_of(kResolution, 32) == kZaberBusy);
  CHECK(bench.setting(kResolution) == 64);
  bench.pass(60s);
  CHECK(bench.error_of(kResolution, 32) == 0);
}

TEST_CASE("another resolution scales what the counter starts at, what was missed and where an axis sticks") {
  ChainBench bench;
  const double step = 0.00635 / 64;
  bench.home();
  bench.go_to(10000);
  bench.send(kSetPosition, 2000);  // the counter's 0 lies at 8000
  bench.send(kResolution, 32);
  CHECK(bench.read(kPosition) == 1000);
  CHECK(bench.millimetres() == Approx(10000 * step));
  CHECK(bench.device.number() == 1);

  bench.device.stick(bench.now);
  bench.go_to(2000);  // 1000 steps of half the resolution that the axis does not follow
  CHECK(bench.millimetres() == Approx(10000 * step));
  bench.send(kResolution, 64);
  CHECK(bench.millimetres() == Approx(10000 * step));
  CHECK(bench.read(kPosition) == 4000);
  bench.device.free(bench.now);
  CHECK(bench.millimetres() == Approx(10000 * step));
  bench.go_to(4200);
  CHECK(bench.millimetres() == Approx(10200 * step));
  bench.send(kResolution, 128);
  CHECK(bench.millimetres() == Approx(10200 * step));
  CHECK(bench.read(kPosition) == 8400);
}

TEST_CASE("another resolution rounds a place between its steps, from its own time on") {
  ChainBench bench;
  const double step = 0.00635 / 64;
  bench.home();
  bench.go_to(12345);
  bench.pass(1s);
  bench.send(kResolution, 32);
  CHECK(bench.read(kPosition) == 6173);
  CHECK(bench.millimetres() == Approx(2 * 6173 * step).epsilon(1e-12));
  CHECK(bench.device.position(bench.now - 1ns).value() == Approx(12345 * step).epsilon(1e-12));
}

TEST_CASE("set position gives the place another number, also in motion, and counts as homing") {
  ChainBench bench;
  CHECK((bench.setting(kMode) & kZaberHomed) == 0);
  const double before = bench.millimetres();
  CHECK(bench.send(kSetPosition, 321) == std::vector<ZaberFrame>{{1, kSetPosition, 321, 5}});
  CHECK(bench.millimetres() == before);
  CHECK(bench.read(kPosition) == 321);
  CHECK(bench.setting(kSetPosition) == 321);
  CHECK((bench.setting(kMode) & kZaberHomed) != 0);
  bench.go_to(0);
  CHECK(bench.millimetres() == Approx(before - 321 * 0.00635 / 64));
  bench.send(kMoveAbsolute, 100000);
  bench.pass(1s);
  bench.send(kSetPosition, 7);
  CHECK(bench.read(kPosition) == 7);
}

TEST_CASE("each memory cell of a chain device keeps its own byte") {
  ChainBench bench;
  for (const int cell : {0, 1, 63, 126, 127}) {
    INFO(cell);
    CHECK(bench.read(kMemory, cell) == cell);
    CHECK(bench.read(kMemory, 0x80 | cell | (cell + 128) << 8) == (cell | (cell + 128) << 8));
  }
  for (const int cell : {0, 1, 63, 126, 127}) {
    INFO(cell);
    CHECK(bench.read(kMemory, cell | 77 << 8) == (cell | (cell + 128) << 8));  // the byte of a reading is not written
  }
  CHECK(bench.read(kMemory, 0x80 | 5 | 0x1FF << 8) == (5 | 0xFF << 8));
}
