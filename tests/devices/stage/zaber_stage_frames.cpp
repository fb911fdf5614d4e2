// Frames that the Zaber driver did not ask for, and which of them end a motion, without a wire.
#include <catch2/catch.hpp>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("an error that a Zaber device tells unasked is told once and leaves the stage armed") {
  StageAlone alone;
  alone.ready();
  alone.chain.say({2, kError, 15, 0});
  check_fault([&] { (void)alone.stage.state(Axis::kX); }, "TB-STAGE-REFUSED", "stage y (device 2)", "error 15");
  CHECK(alone.stage.armed());
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "none");
  alone.chain.say({2, kError, 15, 77});  // an answer to somebody
  alone.chain.say({4, kError, 15, 0});
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "none");
}

TEST_CASE("a Zaber axis that tells its place unasked stands there, and no other frame moves it") {
  StageAlone alone;
  alone.ready();
  const auto beyond = [&] {  // from 80000 steps 2 mm are too far; then nothing is asked
    alone.sent();
    const std::string id = fault_id_of([&] { alone.stage.start_move_by(Axis::kX, Millimetres(2.0), {}); });
    if (id == "none") (void)alone.stage.stop(Axis::kX);
    return id == "TB-STAGE-LIMIT" && alone.sent().empty();
  };
  for (const ZaberFrame& frame : {ZaberFrame{1, kPosition, 80000, 0}, ZaberFrame{1, kMoveTracking, 80000, 9},
                                  ZaberFrame{1, kManualTracking, 80000, 9}, ZaberFrame{2, kMoveTracking, 80000, 0},
                                  ZaberFrame{1, kLimitActive, 80000, 0}, ZaberFrame{1, kError, 0, 9}}) {
    INFO(name(frame.command));
    alone.chain.say(frame);
    (void)alone.stage.state(Axis::kZ);
    CHECK_FALSE(beyond());
  }
  for (const ZaberCommand tracks : {kMoveTracking, kManualTracking}) {
    (void)alone.stage.state(Axis::kX);
    alone.chain.say({1, tracks, 80000, 0});
    (void)alone.stage.state(Axis::kZ);
    CHECK(beyond());
  }
}

TEST_CASE("a Zaber axis at constant speed has ended when it tells its limit unasked, and by no other frame") {
  StageAlone alone;
  alone.ready();
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}};
  alone.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0));
  const std::uint8_t id = alone.chain.sent[1].id;
  REQUIRE(alone.chain.sent[1].command == kConstantSpeed);
  alone.sent();
  for (const ZaberFrame& frame :
       {ZaberFrame{1, kMoveTracking, 700, 0}, ZaberFrame{1, kPosition, 700, 0}, ZaberFrame{1, kConstantSpeed, 700, id},
        ZaberFrame{1, kLimitActive, 700, static_cast<std::uint8_t>(id + 1)}, ZaberFrame{2, kLimitActive, 700, 0}}) {
    INFO(name(frame.command));
    alone.chain.say(frame);
    (void)alone.stage.state(Axis::kX);
    CHECK(fault_id_of([&] { alone.stage.start_move_by(Axis::kX, Millimetres(0.001), {}); }) == "TB-STAGE-MOVING");
  }
  alone.sent();
  alone.chain.say({1, kLimitActive, 90000, 0});
  CHECK(alone.stage.wait(Axis::kX) == Millimetres(8.9296875));
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kStatus, 0, 0}});  // its place was told, and is not asked for
}

TEST_CASE("a Zaber axis that tells a limit while it goes to a target goes on") {
  StageAlone alone;
  alone.ready();
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}};
  alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});
  const std::uint8_t id = alone.chain.sent[1].id;
  alone.sent();
  for (const ZaberFrame& frame :
       {ZaberFrame{1, kLimitActive, 90000, 0}, ZaberFrame{1, kMoveAbsolute, 90000, static_cast<std::uint8_t>(id + 1)},
        ZaberFrame{2, kMoveAbsolute, 90000, id}, ZaberFrame{1, kMoveAbsolute, 90000, 0}}) {
    alone.chain.say(frame);
    (void)alone.stage.state(Axis::kX);
    CHECK(fault_id_of([&] { alone.stage.start_move_by(Axis::kX, Millimetres(0.001), {}); }) == "TB-STAGE-MOVING");
  }
  alone.sent();
  alone.chain.say({1, kMoveAbsolute, 90000, id});
  CHECK(alone.stage.wait(Axis::kX) == Millimetres(8.9296875));
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kStatus, 0, 0}});
}

TEST_CASE("an error under the id of a Zaber axis' motion refuses the motion") {
  StageAlone alone;
  alone.ready();
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}};
  alone.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0));
  alone.chain.say({1, kError, 22, alone.chain.sent[1].id});
  check_fault([&] { (void)alone.stage.wait(Axis::kX); }, "TB-STAGE-REFUSED", "stage x (device 1)", "error 22");
}

TEST_CASE("message ids of motions that have ended are used again, and a motion under way keeps its own") {
  StageAlone alone;
  alone.ready();
  alone.stage.start_move_to(Axis::kZ, Millimetres(40.0), MillimetresPerSecond(0.001));
  const std::uint8_t id = alone.chain.sent[2].id;
  REQUIRE(alone.chain.sent[2].command == kMoveAbsolute);
  const bool replaced = GENERATE(false, true);
  std::vector<bool> used(256);
  for (int i = 0; i < 300; ++i) {
    alone.chain.take_sent();
    if (replaced) {
      alone.stage.start_move_to(Axis::kX, Millimetres(1.0 + i % 2), {});
    } else {
      (void)alone.stage.stop(Axis::kX);
    }
    for (const ZaberFrame& one : alone.chain.sent) used[one.id] = true;
  }
  CHECK(std::count(used.begin(), used.end(), true) == 253);
  CHECK_FALSE(used[0]);
  CHECK_FALSE(used[255]);
  CHECK_FALSE(used[id]);
}

TEST_CASE("a move of another program is not ended by a frame that nobody asked for") {
  StageAlone alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}};
  alone.stage.arm();
  alone.chain.say({1, kManualTracking, 700, 0});
  (void)alone.stage.state(Axis::kY);
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}, {{kStatus, 0}}};
  const Nanoseconds begin = alone.clock.now();
  CHECK(alone.stage.wait(Axis::kX).value() == 0.0);  // asked for once it is idle
  CHECK(alone.clock.now() - begin == 100ms);
}

TEST_CASE("a relative Zaber move may follow one that has ended and was not waited for") {
  StageAlone alone;
  alone.ready();
  alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {});
  alone.clock.wait_until(alone.clock.now() + 60s);
  alone.stage.start_move_by(Axis::kX, Millimetres(1.0), {});
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(2.0).margin(1e-4));
}

TEST_CASE("a refused Zaber move is over") {
  StageAlone alone;
  alone.ready();
  alone.instead[{1, kMoveAbsolute}] = {{{kError, 20}}};
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-REFUSED");
  alone.sent();
  CHECK(alone.stage.wait(Axis::kX).value() == 0.0);
  CHECK(alone.sent().empty());
}

TEST_CASE("homing a Zaber axis sends one instruction, waits for its answer and asks whether it is homed") {
  StageAlone alone;
  alone.ready();
  alone.stage.home(Axis::kX);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kHome, 0, 0}, {1, kStatus, 0, 0}, {1, kReturnSetting, 40, 0}});
}

TEST_CASE("stopping a Zaber axis sends one stop and waits for its answer") {
  StageAlone alone;
  alone.ready();
  CHECK(alone.stage.stop(Axis::kX).value() == 0.0);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kStop, 0, 0}, {1, kStatus, 0, 0}});
}
