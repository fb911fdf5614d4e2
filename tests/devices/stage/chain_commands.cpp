// Instructions to the simulated device: which it hears, refuses and answers, at the edges of what it takes.
#include <catch2/catch.hpp>
#include <limits>

#include "tests/devices/stage/chain_bench.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("a chain device hears its number, its alias and the number of all") {
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

TEST_CASE("a chain device is numbered by its place on the line, or alone from 1 to 254") {
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

TEST_CASE("each instruction that a chain device knows is answered under its own number") {
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
  CHECK(answer(kDeviceId, 1) == std::pair(kDeviceId, 5082));
  CHECK(answer(kFirmware, 1) == std::pair(kFirmware, 521));
  CHECK(answer(kSupplyVoltage, 1) == std::pair(kSupplyVoltage, 144));
  CHECK(answer(kStatus, 1) == std::pair(kStatus, 0));
  CHECK(answer(kEcho, 1234) == std::pair(kEcho, 1234));
  CHECK(answer(kPosition, 1) == std::pair(kPosition, 0));
  CHECK(answer(kRestoreSettings, 0) == std::pair(kRestoreSettings, 0));
  CHECK(answer(kRestoreSettings, 1) == std::pair(kError, 36));
  CHECK(answer(kRestoreSettings, -1) == std::pair(kError, 36));
  CHECK(answer(kReturnSetting, 40) == std::pair(kMode, 0));
  CHECK(answer(kReturnSetting, 45) == std::pair(kSetPosition, 0));
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

TEST_CASE("a chain device has sixteen stored positions, each its own, from homing on") {
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
    CHECK(bench.send(kMoveToStoredPosition, place).empty());
    CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kMoveToStoredPosition, 100 + place, 5}});
  }
  bench.send(kMaximumPosition, 115);
  CHECK(bench.error_of(kMoveToStoredPosition, 15) == 0);
  bench.pass(60s);
  bench.send(kMaximumPosition, 114);
  CHECK(bench.error_of(kMoveToStoredPosition, 15) == 18);
  CHECK(bench.error_of(kMoveToStoredPosition, 1) == 0);
}

TEST_CASE("moves of a chain device end within its travel, whose ends are included") {
  ChainBench bench;
  bench.home();
  CHECK(bench.error_of(kMoveAbsolute, -1) == 20);
  CHECK(bench.error_of(kMoveAbsolute, 604725) == 20);
  CHECK(bench.error_of(kMoveRelative, -1) == 21);
  CHECK(bench.read(kStatus) == 0);
  bench.go_to(604724);
  CHECK(bench.error_of(kMoveRelative, 1) == 21);
  CHECK(bench.error_of(kMoveRelative, -604725) == 2146);
  CHECK(bench.send(kMoveRelative, -604724).empty());
  CHECK(bench.pass(300s) == std::vector<ZaberFrame>{{1, kMoveRelative, 0, 5}});
  CHECK(bench.error_of(kMoveRelative, 604725) == 2146);
  CHECK(bench.send(kMoveRelative, 604724).empty());
  CHECK(bench.pass(300s) == std::vector<ZaberFrame>{{1, kMoveRelative, 604724, 5}});
  CHECK(bench.send(kMoveRelative, 0).empty());
  CHECK(bench.pass(0s) == std::vector<ZaberFrame>{{1, kMoveRelative, 604724, 5}});
  bench.go_to(0);
  bench.send(kMaximumRelativeMove, 500);
  CHECK(bench.error_of(kMoveRelative, 501) == 2146);
  CHECK(bench.send(kMoveRelative, 500).empty());
  CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kMoveRelative, 500, 5}});
  CHECK(bench.error_of(kMoveRelative, -501) == 2146);
  CHECK(bench.send(kMoveRelative, -500).empty());
  CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kMoveRelative, 0, 5}});
}

TEST_CASE("constant speeds of a chain device reach to 512 times its resolution less one") {
  ChainBench bench;
  bench.home();
  CHECK(bench.error_of(kConstantSpeed, 32768) == 22);
  CHECK(bench.error_of(kConstantSpeed, -32768) == 22);
  CHECK(bench.send(kConstantSpeed, 32767) == std::vector<ZaberFrame>{{1, kConstantSpeed, 32767, 5}});
  CHECK(bench.send(kConstantSpeed, -32767) == std::vector<ZaberFrame>{{1, kConstantSpeed, -32767, 5}});
}

TEST_CASE("a homing chain device is busy for every move, and for a stop when it is told so") {
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

TEST_CASE("the status of a chain device is the number of what is under way") {
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

TEST_CASE("without auto-reply a chain device answers what asks and what fails, and nothing else") {
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

TEST_CASE("a reset stops a chain device where it is, unanswered, and starts its counter there") {
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
