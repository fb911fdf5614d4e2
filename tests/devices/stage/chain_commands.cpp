// Instructions to the simulated device: which it hears, refuses and answers, at the edges of what it takes.
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("simulated Zaber device: accepts frames to its number, its alias and the broadcast number 0") {
  ChainBench bench;
  CHECK(bench.device.hears(0));
  CHECK(bench.device.hears(1));
  CHECK_FALSE(bench.device.hears(2));
  CHECK_FALSE(bench.device.hears(255));
  bench.send(kAlias, 1);
  CHECK(bench.device.hears(1));
  bench.send(kAlias, 254);
  CHECK(bench.device.hears(254));
  CHECK(bench.device.hears(1));
  CHECK_FALSE(bench.device.hears(253));
  CHECK(bench.send(kEcho, 4, 254) == std::vector<ZaberFrame>{{1, kEcho, 4, 5}});
  CHECK(bench.send(kEcho, 4, 0) == std::vector<ZaberFrame>{{1, kEcho, 4, 5}});
  ChainDeviceOptions options;
  options.number = 2;
  ChainBench second(options);
  CHECK_FALSE(second.device.hears(1));
  second.send(kAlias, 1, 2);
  CHECK(second.device.hears(1));
}

TEST_CASE("simulated Zaber device: gets its number from its place on the line, or 1 to 254 if addressed alone") {
  ChainBench bench;
  for (const std::int32_t number : {0, -1, 255, 256}) {
    CHECK(bench.error_of(kRenumber, number) == 2);
    CHECK(bench.device.number() == 1);
  }
  CHECK(bench.send(kRenumber, 254) == std::vector<ZaberFrame>{{254, kRenumber, 60, 5}});
  CHECK(bench.device.number() == 254);
  CHECK_FALSE(bench.device.hears(1));
  CHECK(bench.send(kRenumber, 1, 254) == std::vector<ZaberFrame>{{1, kRenumber, 60, 5}});
  std::vector<ZaberFrame> replies;
  bench.device.receive({0, kRenumber, 0, 5}, bench.now, 9, replies);
  CHECK(replies == std::vector<ZaberFrame>{{9, kRenumber, 60, 5}});
  CHECK(bench.device.number() == 9);
}

TEST_CASE("simulated Zaber device: answers each known instruction under its own number, and refuses unknown ones") {
  ChainDeviceOptions options;
  options.device_id = 5082;
  options.firmware = 521;
  options.supply_decivolts = 144;
  options.number = 3;
  ChainBench bench(options);
  const auto answer = [&](ZaberCommand command, std::int32_t data) {
    const auto replies = bench.send(command, data, 3);
    REQUIRE(replies.size() == 1);
    CHECK(replies[0].device == 3);
    CHECK(replies[0].id == 5);
    return std::pair(replies[0].command, replies[0].data);
  };
  using Says = std::pair<ZaberCommand, std::int32_t>;
  for (const auto& [asked, said] : std::vector<std::pair<Says, Says>>{{{kDeviceId, 1}, {kDeviceId, 5082}},
                                                                      {{kFirmware, 1}, {kFirmware, 521}},
                                                                      {{kSupplyVoltage, 1}, {kSupplyVoltage, 144}},
                                                                      {{kStatus, 1}, {kStatus, 0}},
                                                                      {{kEcho, 1234}, {kEcho, 1234}},
                                                                      {{kPosition, 1}, {kPosition, 0}},
                                                                      {{kRestoreSettings, 0}, {kRestoreSettings, 0}},
                                                                      {{kRestoreSettings, 1}, {kError, 36}},
                                                                      {{kRestoreSettings, -1}, {kError, 36}},
                                                                      {{kReturnSetting, 40}, {kMode, 0}},
                                                                      {{kReturnSetting, 45}, {kSetPosition, 0}}}) {
    INFO(name(asked.first));
    CHECK(answer(asked.first, asked.second) == said);
  }
  // 44 + 256 and 44 - 256: no other number is taken for it.
  for (const std::int32_t none : {36, 50, 60, 0, -1, 255, 256, 300, -212}) {
    INFO(none);
    CHECK(answer(kReturnSetting, none) == std::pair(kError, 53));
  }
  for (const int unknown : {3, 8, 9, 10, 24, 34, 56, 61, 254, 255}) {
    INFO(unknown);
    CHECK(answer(static_cast<ZaberCommand>(unknown), 0) == std::pair(kError, 64));
  }
}

TEST_CASE("simulated Zaber device: has sixteen separate stored positions, available after homing") {
  ChainBench bench;
  for (const std::int32_t place : {0, 15}) {
    CHECK(bench.error_of(kStorePosition, place) == 1601);
    CHECK(bench.send(kReturnStoredPosition, place) == std::vector<ZaberFrame>{{1, kReturnStoredPosition, 0, 5}});
    CHECK(bench.error_of(kMoveToStoredPosition, place) == 1801);
  }
  for (const std::int32_t none : {-1, 16}) {
    CHECK(bench.error_of(kStorePosition, none) == 1600);
    CHECK(bench.error_of(kReturnStoredPosition, none) == 1700);
    CHECK(bench.error_of(kMoveToStoredPosition, none) == 1800);
  }
  bench.home();
  for (const std::int32_t place : {0, 1, 15}) {
    bench.go_to(100 + place);
    CHECK(bench.send(kStorePosition, place) == std::vector<ZaberFrame>{{1, kStorePosition, place, 5}});
  }
  for (const std::int32_t place : {15, 1, 0}) {
    CHECK(bench.read(kReturnStoredPosition, place) == 100 + place);
    bench.moves(kMoveToStoredPosition, place, 100 + place);
  }
  bench.send(kMaximumPosition, 115);
  CHECK(bench.error_of(kMoveToStoredPosition, 15) == 0);
  bench.pass(60s);
  bench.send(kMaximumPosition, 114);
  CHECK(bench.error_of(kMoveToStoredPosition, 15) == 18);
  CHECK(bench.error_of(kMoveToStoredPosition, 1) == 0);
}

TEST_CASE("simulated Zaber device: moves must end within its travel, both ends included") {
  ChainBench bench;
  bench.home();
  CHECK(bench.error_of(kMoveAbsolute, -1) == 20);
  CHECK(bench.error_of(kMoveAbsolute, 604725) == 20);
  CHECK(bench.error_of(kMoveRelative, -1) == 21);
  CHECK(bench.read(kStatus) == 0);
  bench.go_to(604724);
  CHECK(bench.error_of(kMoveRelative, 1) == 21);
  CHECK(bench.error_of(kMoveRelative, -604725) == 2146);
  bench.moves(kMoveRelative, -604724, 0);
  CHECK(bench.error_of(kMoveRelative, 604725) == 2146);
  bench.moves(kMoveRelative, 604724, 604724);
  CHECK(bench.send(kMoveRelative, 0).empty());
  CHECK(bench.pass(0s) == std::vector<ZaberFrame>{{1, kMoveRelative, 604724, 5}});
  bench.go_to(0);
  bench.send(kMaximumRelativeMove, 500);
  CHECK(bench.error_of(kMoveRelative, 501) == 2146);
  bench.moves(kMoveRelative, 500, 500);
  CHECK(bench.error_of(kMoveRelative, -501) == 2146);
  bench.moves(kMoveRelative, -500, 0);
}

TEST_CASE("simulated Zaber device: is busy for every move while homing, and for a stop if set so") {
  ChainDeviceOptions options;
  options.refuses_stop_while_homing = GENERATE(false, true);
  ChainBench bench(options);
  CHECK(bench.send(kHome, 0).empty());
  bench.pass(500ms);
  CHECK(bench.read(kStatus) == 1);
  for (const ZaberCommand move : {kHome, kMoveAbsolute, kMoveRelative, kConstantSpeed, kMoveToStoredPosition}) {
    CHECK(bench.error_of(move, 0) == kZaberBusy);
  }
  CHECK(bench.error_of(kStop, 0) == (options.refuses_stop_while_homing ? kZaberBusy : 0));
  CHECK(bench.read(kStatus) == (options.refuses_stop_while_homing ? 1 : 23));
  bench.pass(60s);
  CHECK((bench.setting(kMode) & kZaberHomed) == (options.refuses_stop_while_homing ? kZaberHomed : 0));
  CHECK(bench.error_of(kStop, 0) == 0);
}

TEST_CASE("simulated Zaber device: its status is the number of the instruction in progress") {
  ChainBench bench;
  bench.home();
  bench.go_to(100);
  bench.send(kStorePosition, 0);
  for (const auto& [command, data] :
       {std::pair(kMoveAbsolute, 90000), std::pair(kMoveRelative, 1000), std::pair(kMoveToStoredPosition, 0),
        std::pair(kConstantSpeed, 3000), std::pair(kStop, 0)}) {
    CHECK(bench.error_of(command, data) == 0);
    CHECK(bench.read(kStatus) == static_cast<std::int32_t>(command));
    bench.pass(1ms);
  }
  bench.pass(60s);
  CHECK(bench.read(kStatus) == 0);
}

TEST_CASE("simulated Zaber device: without auto-reply it answers only queries and failures") {
  ChainBench bench;
  bench.home();
  CHECK(bench.send(kMode, kZaberNoAutoReply | kZaberHomed | kZaberMoveTracking).empty());
  for (const ZaberCommand asks :
       {kDeviceId, kFirmware, kSupplyVoltage, kStatus, kEcho, kPosition, kRenumber, kReturnStoredPosition}) {
    INFO(name(asks));
    CHECK(bench.send(asks, 1).size() == 1);
  }
  for (const ZaberCommand setting :
       {kResolution, kRunningCurrent, kHoldCurrent, kMode, kHomeSpeed, kTargetSpeed, kAcceleration, kMaximumPosition,
        kMaximumRelativeMove, kSetPosition, kHomeOffset, kAlias, kLock}) {
    INFO(name(setting));
    CHECK(bench.send(kReturnSetting, static_cast<std::int32_t>(setting)).size() == 1);
    CHECK(bench.send(setting, bench.setting(setting)).empty());
    CHECK(bench.send(setting, -5).size() == 1);
  }
  for (const ZaberCommand quiet : {kMemory, kStorePosition, kRestoreSettings}) {
    INFO(name(quiet));
    CHECK(bench.send(quiet, 0).empty());
  }
  for (const ZaberCommand move : {kMoveAbsolute, kMoveRelative, kConstantSpeed, kMoveToStoredPosition, kStop, kHome}) {
    INFO(name(move));
    CHECK(bench.send(move, 15).empty());
    CHECK(bench.pass(300s).empty());
  }
  CHECK(bench.error_of(kMoveAbsolute, -1) == 20);
}

TEST_CASE("simulated Zaber device: a reset stops it in place without an answer and sets its counter to 0") {
  ChainBench bench;
  bench.home();
  bench.send(kTargetSpeed, 2000);
  bench.send(kMoveAbsolute, 300000);
  bench.pass(1s);
  const double there = bench.millimetres();
  CHECK(there > 1.0);
  CHECK(bench.send(kReset, 0).empty());
  CHECK(bench.read(kStatus) == 0);
  CHECK(bench.read(kPosition) == 0);
  CHECK(bench.pass(300s).empty());
  CHECK(bench.millimetres() == there);
  CHECK(bench.setting(kMode) == 0);
  CHECK(bench.setting(kTargetSpeed) == 2000);
  CHECK_FALSE(bench.device.due().has_value());
}

TEST_CASE("simulated Zaber device: a move is answered when it ends, a replaced move never") {
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

TEST_CASE("simulated Zaber device: starts with the settings of its model and its options") {
  using Settings = std::vector<std::pair<ZaberCommand, std::int32_t>>;
  const auto check = [](ChainBench bench, const Settings& settings) {
    for (const auto& [setting, value] : settings) {
      INFO(name(setting));
      CHECK(bench.setting(setting) == value);
    }
  };
  // 60 mm in steps of 1.27 mm / 200 / 64; the setting of the position returns the position.
  check(ChainBench(), {{kResolution, 64},
                       {kRunningCurrent, 10},
                       {kHoldCurrent, 20},
                       {kMode, 0},
                       {kHomeSpeed, 2922},
                       {kTargetSpeed, 2922},
                       {kAcceleration, 111},
                       {kMaximumPosition, 604724},
                       {kMaximumRelativeMove, 604724},
                       {kHomeOffset, 0},
                       {kAlias, 0},
                       {kLock, 0},
                       {kSetPosition, 0}});
  ChainDeviceOptions options;
  options.device_id = 5082;
  options.home_speed = 11;
  options.target_speed = 12;
  options.acceleration = 13;
  options.mode = kZaberHomed | kZaberKnobOff;
  // 50.8 mm in steps of 0.6096 mm / 200 / 64; no home after power-up.
  check(ChainBench(options), {{kMaximumPosition, 1066666},
                              {kMaximumRelativeMove, 1066666},
                              {kHomeSpeed, 11},
                              {kTargetSpeed, 12},
                              {kAcceleration, 13},
                              {kMode, kZaberKnobOff}});
  options.device_id = 7;  // a model that is in no table has the units of the T-LA60A
  ChainBench unknown(options);
  CHECK(unknown.read(kDeviceId) == 7);
  CHECK(unknown.setting(kMaximumPosition) == 604724);
}

TEST_CASE("simulated Zaber device: each setting accepts its lowest and highest value and refuses values beyond them") {
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

TEST_CASE("simulated Zaber device: each reserved mode bit is refused with its own error number, the lowest bit first") {
  ChainBench bench;
  CHECK(bench.error_of(kMode, 1 << 8 | 1 << 10) == 4008);
  CHECK(bench.error_of(kMode, 1 << 10 | 1 << 13) == 4010);
  CHECK(bench.error_of(kMode, 1 << 13 | 1 << 16) == 4013);
  CHECK(bench.error_of(kMode, -1) == 4008);
  CHECK(bench.setting(kMode) == 0);
}

TEST_CASE("simulated Zaber device: speeds and acceleration are limited to 512 times the resolution less one") {
  for (const auto& [resolution, most] : {std::pair(64, 32767), std::pair(32, 16383)}) {
    ChainBench bench;
    bench.send(kResolution, resolution);
    for (const auto& [setting, error] :
         {std::pair(kHomeSpeed, 41), std::pair(kTargetSpeed, 42), std::pair(kAcceleration, 43)}) {
      CHECK(bench.error_of(setting, most) == 0);
      CHECK(bench.error_of(setting, most + 1) == error);
    }
    bench.home();
    for (const std::int32_t fastest : {most, -most}) {
      CHECK(bench.error_of(kConstantSpeed, fastest + fastest / most) == 22);
      CHECK(bench.send(kConstantSpeed, fastest) == std::vector<ZaberFrame>{{1, kConstantSpeed, fastest, 5}});
    }
  }
}

TEST_CASE("simulated Zaber device: firmware before 5.23 refuses a maximum below the present position") {
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

TEST_CASE("simulated Zaber device: while locked, no setting but the lock can be changed") {
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

TEST_CASE("simulated Zaber device: refuses another resolution while it moves") {
  ChainBench bench;
  bench.send(kHome, 0);
  CHECK(bench.error_of(kResolution, 32) == kZaberBusy);
  CHECK(bench.setting(kResolution) == 64);
  bench.pass(60s);
  CHECK(bench.error_of(kResolution, 32) == 0);
}

TEST_CASE("simulated Zaber device: another resolution scales the counter's origin, missed steps and stuck position") {
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

TEST_CASE("simulated Zaber device: another resolution rounds the position to its steps, from that time on") {
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

TEST_CASE("simulated Zaber device: set position renumbers the present position, also in motion, and counts as homing") {
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

TEST_CASE("simulated Zaber device: each memory cell keeps its own byte") {
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
