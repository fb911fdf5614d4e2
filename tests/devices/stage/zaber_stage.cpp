// The Zaber driver without a wire: limits at their edges, what each command sends, and its faults.
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/stage/zaber_stage.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

const std::string kStageX = "stage x (device 1)";

constexpr Millimetres kEnd{8.9296875};  // 90000 steps of x

}  // namespace

TEST_CASE("Zaber stage: moves to the ends of its limits and refuses targets beyond them") {
  ZaberStageOptions options = even_stage();
  options.axes[0].low = Millimetres(2.0);
  options.axes[0].high = Millimetres(6.0);
  ReadyStage alone(options);
  for (const double target : {1.9999, 6.0001, -1.0}) {
    check_fault([&] { alone.stage.start_move_to(Axis::kX, Millimetres(target), {}); }, "TB-STAGE-LIMIT", kStageX,
                "2 to 6 mm");
    check_fault([&] { alone.stage.start_move_by(Axis::kX, Millimetres(target), {}); }, "TB-STAGE-LIMIT", kStageX,
                "2 to 6 mm");
  }
  CHECK(alone.sent().empty());
  for (const double target : {2.0, 6.0}) {
    alone.stage.start_move_to(Axis::kX, Millimetres(target), {});
    CHECK(alone.stage.wait(Axis::kX).value() == Approx(target).margin(1e-4));
  }
}

TEST_CASE("Zaber stage: moves to the end of the device's own travel if its limits are wider") {
  ZaberStageOptions options = even_stage();
  options.axes[0].low = Millimetres(-5.0);
  ReadyStage alone(options);
  // Half a step rounds to the next one.
  for (const double target : {kEnd.value() + 0.00006, -0.00006}) {
    CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(target), {}); }) == "TB-STAGE-LIMIT");
  }
  CHECK(alone.sent().empty());
  for (const double target : {kEnd.value() + 0.00004, -0.00004}) {
    alone.stage.start_move_to(Axis::kX, Millimetres(target), {});
    CHECK(alone.stage.wait(Axis::kX).value() == Approx(target).margin(1e-4));
  }
}

TEST_CASE("Zaber stage: accepts speeds from one unit to the highest, both included") {
  ReadyStage alone;
  const double unit = 9.375 * 0.00635 / 64;
  for (const double speed : {0.0, -1.0, 0.49 * unit, 4.46484376}) {
    check_fault([&] { alone.stage.start_move_to(Axis::kX, Millimetres(1.0), MillimetresPerSecond(speed)); },
                "TB-STAGE-LIMIT", kStageX, "4.46484 mm/s");
  }
  CHECK(fault_id_of([&] { alone.stage.start_speed(Axis::kX, MillimetresPerSecond(-0.49 * unit)); }) ==
        "TB-STAGE-LIMIT");
  alone.sent();
  for (const double units : {0.51, 1.0, 4800.0}) {
    alone.stage.start_move_to(Axis::kX, Millimetres(0.001), MillimetresPerSecond(units * unit));
    (void)alone.stage.wait(Axis::kX);
    alone.stage.start_move_to(Axis::kX, Millimetres(0.0), MillimetresPerSecond(units * unit));
    (void)alone.stage.wait(Axis::kX);
  }
  std::vector<std::int32_t> speeds;
  for (const ZaberFrame& one : alone.sent()) {
    if (one.command == kTargetSpeed) speeds.push_back(one.data);
  }
  CHECK(speeds == std::vector<std::int32_t>{1, 4800});
}

TEST_CASE("Zaber stage: each move asks whether the axis is homed, then sends speed and target") {
  ReadyStage alone;
  alone.stage.start_move_to(Axis::kX, kEnd, MillimetresPerSecond(2.232421875));
  CHECK(alone.sent() ==
        std::vector<ZaberFrame>{
            {1, kReturnSetting, 40, 0}, {1, kTargetSpeed, 2400, 0}, {1, kMoveAbsolute, 90000, 0}, {1, kStatus, 0, 0}});
  CHECK(alone.stage.wait(Axis::kX) == kEnd);
  alone.sent();
  alone.stage.start_move_by(Axis::kX, Millimetres(-4.46484375), {});
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kPosition, 0, 0},
                                                {1, kReturnSetting, 40, 0},
                                                {1, kTargetSpeed, 4800, 0},
                                                {1, kMoveRelative, -45000, 0},
                                                {1, kStatus, 0, 0}});
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));
  alone.sent();
  alone.stage.start_speed(Axis::kX, MillimetresPerSecond(-2.232421875));
  CHECK(alone.sent() ==
        std::vector<ZaberFrame>{{1, kReturnSetting, 40, 0}, {1, kConstantSpeed, -2400, 0}, {1, kStatus, 0, 0}});
  alone.stage.start_speed(Axis::kX, MillimetresPerSecond(2.232421875));
  CHECK(alone.sent() ==
        std::vector<ZaberFrame>{
            {1, kReturnSetting, 40, 0}, {1, kPosition, 0, 0}, {1, kConstantSpeed, 2400, 0}, {1, kStatus, 0, 0}});
  CHECK(alone.stage.wait(Axis::kX) == kEnd);
}

TEST_CASE("Zaber stage: constant speed ends at the nearer of its limit and the device's, in both directions") {
  ZaberStageOptions options = even_stage();
  const auto [low, high, down, up] = GENERATE(table<double, double, std::int32_t, std::int32_t>(
      {{0.0, 60.0, -1, -1}, {0.0, 8.9296875, -1, -1}, {-1.0, 1e9, -1, -1}, {0.9921875, 7.9375, 10000, 80000}}));
  options.axes[0].low = Millimetres(low);
  options.axes[0].high = Millimetres(high);
  ReadyStage alone(options);
  for (const auto& [speed, end] : {std::pair(2.232421875, up), std::pair(-2.232421875, down)}) {
    alone.stage.start_speed(Axis::kX, MillimetresPerSecond(speed));
    ScriptedChain::Frames sent = alone.sent();
    std::erase_if(sent,
                  [](const ZaberFrame& one) { return one.command != kMoveAbsolute && one.command != kConstantSpeed; });
    const ZaberFrame constant{1, kConstantSpeed, speed > 0.0 ? 2400 : -2400, 0};
    CHECK(sent == std::vector<ZaberFrame>{end < 0 ? constant : ZaberFrame{1, kMoveAbsolute, end, 0}});
    (void)alone.stage.wait(Axis::kX);
    CHECK(alone.steps_of_x() == Approx(end >= 0 ? end : speed > 0.0 ? 90000 : 0).margin(1e-6));
  }
}

TEST_CASE("Zaber stage: a relative move starts from the position the device reports") {
  ReadyStage alone;
  alone.instead[{1, kPosition}] = {{{kPosition, 80000}}};
  CHECK(fault_id_of([&] { alone.stage.start_move_by(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-LIMIT");
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kPosition, 0, 0}});
  // Its position is now known, and nothing is requested.
  CHECK(fault_id_of([&] { alone.stage.start_move_by(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-LIMIT");
  CHECK(alone.sent().empty());
  alone.take(1, kSetPosition, 80000);
  alone.instead.clear();
  alone.stage.start_move_by(Axis::kX, Millimetres(0.9921875), {});
  CHECK(alone.stage.wait(Axis::kX) == kEnd);
}

TEST_CASE("Zaber stage: a speed that the device refused is sent again with the next move") {
  ReadyStage alone;
  alone.instead[{1, kTargetSpeed}] = {{{kError, 42}}};
  check_fault([&] { alone.stage.start_move_to(Axis::kX, kEnd, MillimetresPerSecond(1.0)); }, "TB-STAGE-REFUSED",
              kStageX, "error 42");
  CHECK(alone.stage.armed());
  alone.sent();
  for (const auto& [speed, data] : {std::pair(4.46484375, 4800), std::pair(9.375 * 0.00635 / 64, 1)}) {
    CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, kEnd, MillimetresPerSecond(speed)); }) ==
          "TB-STAGE-REFUSED");
    CHECK(alone.sent()[1] == ZaberFrame{1, kTargetSpeed, data, 0});
  }
  alone.instead.clear();
  alone.stage.start_move_to(Axis::kX, kEnd, {});
  CHECK(alone.sent()[1] == ZaberFrame{1, kTargetSpeed, 4800, 0});
}

TEST_CASE("Zaber stage: a fault of a stage that is not ready names the axis, and nothing is sent") {
  StageAlone alone;
  check_fault([&] { (void)alone.stage.state(Axis::kX); }, "TB-STAGE-NOT-ARMED", "stage");
  alone.stage.arm();
  alone.sent();
  check_fault([&] { alone.stage.start_move_to(Axis::kY, Millimetres(1.0), {}); }, "TB-STAGE-NOT-HOMED",
              "stage y (device 2)");
  CHECK(alone.sent().empty());
  for (const Axis axis : {Axis::kX, Axis::kZ}) alone.stage.home(axis);
  alone.stage.start_move_to(Axis::kX, kEnd, {});
  alone.sent();
  check_fault([&] { alone.stage.start_move_by(Axis::kX, Millimetres(-0.25), {}); }, "TB-STAGE-LIMIT", kStageX,
              "-0.25 mm");
  check_fault([&] { alone.stage.start_move_by(Axis::kX, Millimetres(0.25), {}); }, "TB-STAGE-MOVING", kStageX,
              "0.25 mm");
  CHECK(alone.chain.count(kMoveRelative) == 0);
  CHECK(alone.stage.halt());
  check_fault([&] { (void)alone.stage.state(Axis::kX); }, "TB-STAGE-HALTED", "stage");
}

TEST_CASE("Zaber stage: an axis that is no longer homed is not moved") {
  ReadyStage alone;
  alone.take(1, kMode, kZaberMessageIds | kZaberKnobOff);
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, kEnd, {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kReturnSetting, 40, 0}});
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, kEnd, {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(alone.sent().empty());
  alone.instead[{1, kHome}] = {{{kHome, 0}}};  // it says that it is at home, and its mode does not
  CHECK(fault_id_of([&] { alone.stage.home(Axis::kX); }) == "TB-STAGE-NOT-HOMED");
}

TEST_CASE("Zaber stage: state reports activity from the device's status, and its position") {
  const auto [status, activity] = GENERATE(table<std::int32_t, Activity>({{0, Activity::kIdle},
                                                                          {1, Activity::kHoming},
                                                                          {10, Activity::kByHand},
                                                                          {23, Activity::kStopping},
                                                                          {20, Activity::kMoving},
                                                                          {22, Activity::kMoving}}));
  ReadyStage alone;
  alone.clock.wait_until(1h);
  alone.instead[{1, kStatus}] = {{{kStatus, status}}};
  alone.instead[{1, kPosition}] = {{{kPosition, 45000}}};
  const AxisState state = alone.stage.state(Axis::kX);
  CHECK(state.activity == activity);
  CHECK(state.time == 1h);
  CHECK(state.microsteps == 45000);
  CHECK(state.position.value() == Approx(4.46484375));
  CHECK(state.homed);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kStatus, 0, 0}, {1, kPosition, 0, 0}});
}

TEST_CASE("Zaber stage: send_home needs no reply, leaves the stage disarmed, and waits one reply timeout") {
  ReadyStage alone;
  const Nanoseconds begin = alone.clock.now();
  CHECK(alone.stage.send_home(Axis::kZ));
  CHECK_FALSE(alone.stage.armed());
  CHECK(alone.clock.now() == begin + 5s);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{3, kHome, 0, 0}});
  CHECK(alone.chain.opened == 1);
  alone.stage.disarm();
  alone.chain.refused_openings = 1;
  CHECK_FALSE(alone.stage.send_home(Axis::kZ));
  CHECK(alone.stage.send_home(Axis::kY));
  CHECK(alone.sent() == std::vector<ZaberFrame>{{2, kHome, 0, 0}});
  alone.chain.lost = true;
  CHECK_FALSE(alone.stage.send_home(Axis::kX));
  alone.chain.lost = false;
  CHECK(alone.stage.send_home(Axis::kX));
  CHECK(alone.chain.opened == 4);
}

TEST_CASE("Zaber stage: an unsolicited device error is reported once, and the stage stays armed") {
  ReadyStage alone;
  alone.chain.say({2, kError, 15, 0});
  check_fault([&] { (void)alone.stage.state(Axis::kX); }, "TB-STAGE-REFUSED", "stage y (device 2)", "error 15");
  CHECK(alone.stage.armed());
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "none");
  alone.chain.say({2, kError, 15, 77});  // an answer to somebody
  alone.chain.say({4, kError, 15, 0});
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "none");
}

TEST_CASE("Zaber stage: only an unsolicited tracking report updates the known position") {
  ReadyStage alone;
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

TEST_CASE("Zaber stage: a constant speed ends at an unsolicited limit report, and at no other frame") {
  ReadyStage alone;
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

TEST_CASE("Zaber stage: a limit report during a move to a target does not end the move") {
  ReadyStage alone;
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

TEST_CASE("Zaber stage: an error with the message id of a motion refuses that motion") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}};
  alone.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0));
  alone.chain.say({1, kError, 22, alone.chain.sent[1].id});
  check_fault([&] { (void)alone.stage.wait(Axis::kX); }, "TB-STAGE-REFUSED", "stage x (device 1)", "error 22");
}

TEST_CASE("Zaber stage: message ids of ended motions are used again, and a motion in progress keeps its own") {
  ReadyStage alone;
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

TEST_CASE("Zaber stage: an unsolicited frame does not end a move of another program") {
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

TEST_CASE("Zaber stage: a relative move may follow a move that ended without being waited for") {
  ReadyStage alone;
  alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {});
  alone.clock.wait_until(alone.clock.now() + 60s);
  alone.stage.start_move_by(Axis::kX, Millimetres(1.0), {});
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(2.0).margin(1e-4));
}

TEST_CASE("Zaber stage: a refused move is over") {
  ReadyStage alone;
  alone.instead[{1, kMoveAbsolute}] = {{{kError, 20}}};
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-REFUSED");
  alone.sent();
  CHECK(alone.stage.wait(Axis::kX).value() == 0.0);
  CHECK(alone.sent().empty());
}

TEST_CASE(
    "Zaber stage: homing and stopping send one instruction and wait for its answer, homing checks the homed bit") {
  ReadyStage alone;
  alone.stage.home(Axis::kX);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kHome, 0, 0}, {1, kStatus, 0, 0}, {1, kReturnSetting, 40, 0}});
  CHECK(alone.stage.stop(Axis::kX).value() == 0.0);
  CHECK(alone.sent() == std::vector<ZaberFrame>{{1, kStop, 0, 0}, {1, kStatus, 0, 0}});
}
