// The Zaber driver against the simulated chain over a pseudo-terminal, or a socket where named.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

constexpr double kStep = 0.0001;  // mm, no less than any microstep here

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

void check_arms_and_moves(const SimulatedChainOptions& options) {
  ZaberRig rig(options);
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(1.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(1.0).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(1.0).margin(kStep));
}

}  // namespace

TEST_CASE("arming a Zaber stage reads it, moves nothing and writes only what differs") {
  ZaberRig rig;
  rig.stage.arm();
  CHECK(rig.stage.armed());
  CHECK(rig.count(kMoving) == 0);
  CHECK(rig.count({kMode}) == 3);
  CHECK(rig.chain.position(Axis::kX).value() == Approx(5.0).margin(kStep));
  const AxisState state = rig.stage.state(Axis::kX);
  CHECK(state.activity == Activity::kIdle);
  CHECK_FALSE(state.homed);
  const auto identities = rig.stage.identities();
  REQUIRE(identities.size() == 3);
  CHECK(identities[0].model == "Zaber T-LA60A");
  CHECK(identities[2].model == "Zaber T-NA08A50");
  CHECK(identities[2].role == "stage z");
  CHECK(identities[2].firmware == "5.23");
  CHECK(identities[2].origin == Origin::kSimulated);
  rig.stage.arm();
  CHECK(rig.count({kMode}) == 3);
  CHECK(rig.stage.exchanges() == rig.chain.requests().size());
}

TEST_CASE("homing brings an axis to its sensor in process time") {
  ZaberRig rig;
  rig.stage.arm();
  const Nanoseconds begin = rig.clock.now();
  rig.stage.home(Axis::kZ);
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(0.0).margin(kStep));
  CHECK(rig.stage.state(Axis::kZ).homed);
  CHECK_FALSE(rig.stage.state(Axis::kX).homed);
  // 5 mm at 2922 x 9.375 microsteps/s = 1.3046 mm/s, and the ramps.
  CHECK(seconds(rig.clock.now() - begin) == Approx(5.0 / 1.3046).margin(0.3));
}

TEST_CASE("absolute and relative moves end at their targets, in the time of their trapezoid") {
  ZaberRig rig;
  rig.arm_and_home();
  const Nanoseconds begin = rig.clock.now();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), MillimetresPerSecond(4.0));
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kMoving);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(20.0).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(20.0).margin(kStep));
  // 20 mm at 4 mm/s, and one ramp of 4 mm/s at 111 x 0.53578 mm/s^2.
  CHECK(seconds(rig.clock.now() - begin) == Approx(5.0 + 4.0 / 59.47).margin(0.03));
  rig.stage.start_move_by(Axis::kZ, Millimetres(-0.5), MillimetresPerSecond(0.01));
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(19.5).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(19.5).margin(kStep));
}

TEST_CASE("a move takes few exchanges") {
  ZaberRig rig;
  rig.arm_and_home();
  const auto before = rig.stage.exchanges();
  rig.stage.start_move_to(Axis::kZ, Millimetres(2.0), std::nullopt);
  (void)rig.stage.wait(Axis::kZ);
  CHECK(rig.stage.exchanges() - before <= 12);
}

TEST_CASE("the target speed is written only when it changes") {
  ZaberRig rig;
  rig.arm_and_home();
  for (const double target : {1.0, 2.0, 3.0}) {
    rig.stage.start_move_to(Axis::kX, Millimetres(target), MillimetresPerSecond(2.0));
    (void)rig.stage.wait(Axis::kX);
  }
  CHECK(rig.count({kTargetSpeed}) == 1);
}

TEST_CASE("two axes move at once and their replies come in any order") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(20.0), std::nullopt);  // 5 s
  rig.stage.start_move_to(Axis::kZ, Millimetres(4.0), std::nullopt);   // half a second
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(20.0).margin(kStep));
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(4.0).margin(kStep));
  rig.stage.start_move_to(Axis::kX, Millimetres(10.0), std::nullopt);
  rig.stage.start_move_to(Axis::kZ, Millimetres(8.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(8.0).margin(kStep));
  CHECK(rig.stage.state(Axis::kX).activity == Activity::kMoving);
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(10.0).margin(kStep));
}

TEST_CASE("stop brings a moving axis to rest short of its target") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(40.0), MillimetresPerSecond(8.0));
  rig.clock.wait_until(rig.clock.now() + 1s);
  const Millimetres stood = rig.stage.stop(Axis::kZ);
  CHECK(stood.value() == Approx(8.0).margin(1.0));
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kIdle);
  rig.clock.wait_until(rig.clock.now() + 60s);
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(stood.value()).margin(kStep));
  CHECK(rig.stage.stop(Axis::kZ).value() == Approx(stood.value()).margin(kStep));
}

TEST_CASE("a stop that a busy device refuses is sent again") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(40.0), std::nullopt);
  rig.chain.refuse_next(kStop, kZaberBusy);
  CHECK(rig.stage.stop(Axis::kZ).value() < 39.0);
  CHECK(rig.count({kStop}) == 2);
}

TEST_CASE("a move may replace another, a relative one may not") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(40.0), std::nullopt);
  rig.clock.wait_until(rig.clock.now() + 2s);
  CHECK(fault_id_of([&] { rig.stage.start_move_by(Axis::kX, Millimetres(1.0), std::nullopt); }) == "TB-STAGE-MOVING");
  rig.stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(1.0).margin(kStep));
}

TEST_CASE("constant speed ends at the limit, the device's or a narrower one of the bench file") {
  ZaberStageOptions options = paper_stage();
  options.axes[2].high = Millimetres(10.0);
  ZaberRig rig({}, {}, options);
  rig.arm_and_home();
  rig.stage.start_speed(Axis::kX, MillimetresPerSecond(4.0));
  CHECK(rig.count({kConstantSpeed}) == 1);
  CHECK(rig.stage.state(Axis::kX).activity == Activity::kMoving);
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(60.0).margin(kStep));
  rig.stage.start_speed(Axis::kX, MillimetresPerSecond(-4.0));
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(0.0).margin(kStep));
  rig.stage.start_speed(Axis::kZ, MillimetresPerSecond(4.0));
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(10.0).margin(kStep));
  rig.clock.wait_until(rig.clock.now() + 60s);
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(10.0).margin(kStep));
}

TEST_CASE("every error that a device may answer is named and leaves the stage armed") {
  ZaberRig rig;
  rig.arm_and_home();
  for (const std::int32_t code : {20, 21, 22, 64, 255, 1600, 1601, 1700, 1800, 1801, 2146, 3600, 4015}) {
    rig.chain.refuse_next(kMoveAbsolute, code);
    try {
      rig.stage.start_move_to(Axis::kY, Millimetres(3.0), std::nullopt);
      FAIL("error " << code << " was taken for an answer");
    } catch (const Fault& fault) {
      CHECK(fault.id() == "TB-STAGE-REFUSED");
      CHECK(std::string(fault.what()).find(zaber_error_text(code)) != std::string::npos);
      CHECK(std::string(fault.what()).find("move absolute (20)") != std::string::npos);
    }
  }
  rig.chain.refuse_next(kHome, 1);
  CHECK(fault_id_of([&] { rig.stage.home(Axis::kY); }) == "TB-STAGE-REFUSED");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kY, Millimetres(3.0), {}); }) == "TB-STAGE-NOT-HOMED");
  rig.chain.refuse_next(kTargetSpeed, 42);
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kX, Millimetres(3.0), MillimetresPerSecond(1.0)); }) ==
        "TB-STAGE-REFUSED");
  rig.stage.home(Axis::kY);
  rig.stage.start_move_to(Axis::kY, Millimetres(3.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kY).value() == Approx(3.0).margin(kStep));
}

TEST_CASE("unasked frames change nothing, an error among them is reported") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
  for (const ZaberCommand command : {kMoveTracking, kLimitActive, kManualTracking, kMoveAbsolute, kStatus}) {
    rig.chain.inject({3, command, 12345, 0});
    rig.chain.inject({3, command, 12345, 254});  // an id of long ago
    rig.chain.inject({9, command, 12345, 0});    // a device that is not there
  }
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(20.0).margin(kStep));
  rig.chain.inject({2, kError, 14, 0});
  try {
    (void)rig.stage.state(Axis::kZ);
    FAIL("the error was passed over");
  } catch (const Fault& fault) {
    CHECK(fault.id() == "TB-STAGE-REFUSED");
    CHECK(fault.device().find("stage y") != std::string::npos);
    CHECK(std::string(fault.what()).find("supply voltage is too low") != std::string::npos);
  }
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kIdle);
}

TEST_CASE("an axis that another program moves is noticed") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
  rig.chain.power_cycle();
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kZ); }) == "TB-STAGE-ASTRAY");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), {}); }) == "TB-STAGE-NOT-HOMED");
}

TEST_CASE("a move that does not end in its time is stopped and reported") {
  ZaberStageOptions options = paper_stage();
  options.axes[0].home_timeout = 3s;
  ZaberRig rig({}, {}, options);
  rig.connect()->write(encode_without_id({1, kMoveAbsolute, 500000, 0}));  // another program's: 18 s
  rig.stage.arm();
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kX); }) == "TB-STAGE-OVERDUE");
  rig.clock.wait_until(rig.clock.now() + 60s);
  CHECK(rig.chain.position(Axis::kX).value() < 5.0 + 3.5 * 2.8);
  CHECK(rig.stage.armed());
}

TEST_CASE("after a damaged, cut or late reply the query is repeated and the move ends well") {
  long SimulatedChainFaults::*const fault = GENERATE(
      &SimulatedChainFaults::corrupt_reply, &SimulatedChainFaults::cut_reply, &SimulatedChainFaults::late_reply);
  const long number = GENERATE(0L, 5L, 8L, 45L);
  SimulatedChainFaults faults;
  faults.*fault = number;
  ZaberRig rig({}, faults, impatient_stage());
  rig.stage.arm();
  rig.stage.home(Axis::kZ);
  rig.stage.start_move_to(Axis::kZ, Millimetres(2.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(2.0).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(2.0).margin(kStep));
  CHECK(rig.count({kMoveAbsolute}) == 1);
}

TEST_CASE("the chain is renumbered only on request") {
  SimulatedChainOptions chain;
  for (std::size_t i = 0; i < 3; ++i) chain.devices[i].number = static_cast<std::uint8_t>(7 - i);
  ZaberStageOptions options = impatient_stage();
  {
    ZaberRig rig(chain, {}, options);
    CHECK(fault_id_of([&] { rig.stage.arm(); }) == "TB-STAGE-TIMEOUT");
    CHECK(rig.count({kRenumber}) == 0);
  }
  options.renumber = true;
  ZaberRig rig(chain, {}, options);
  rig.arm_and_home();
  CHECK(rig.count({kRenumber}) == 1);
}

TEST_CASE("a device that is not the expected one is refused before its mode is written") {
  SimulatedChainOptions chain;
  SECTION("another model") { std::swap(chain.devices[0].device_id, chain.devices[2].device_id); }
  SECTION("firmware 6, whose units differ") { chain.devices[0].firmware = 606; }
  ZaberRig rig(chain);
  CHECK(fault_id_of([&] { rig.stage.arm(); }) == "TB-STAGE-WRONG-DEVICE");
  CHECK_FALSE(rig.stage.armed());
  CHECK(rig.count({kMode}) == 0);
}

TEST_CASE("identifying a Zaber stage writes nothing and names absent devices") {
  SimulatedChainOptions chain;
  chain.devices.pop_back();
  chain.axes = {0, 1, 1};
  ZaberRig rig(chain, {}, impatient_stage());
  const auto found = rig.stage.identify();
  REQUIRE(found.size() == 3);
  CHECK(found[0].complaint.empty());
  CHECK(found[0].device_id == 60);
  CHECK(found[0].firmware == 523);
  CHECK(found[0].supply.value() == Approx(15.0));
  CHECK_FALSE(found[2].present);
  CHECK_FALSE(found[2].complaint.empty());
  CHECK_FALSE(rig.stage.armed());
  CHECK(rig.stage.identities()[0].firmware == "5.23");
  CHECK(rig.stage.identities()[2].firmware.empty());
  CHECK(rig.count({kDeviceId, kFirmware, kSupplyVoltage, kStatus, kPosition}) == rig.chain.requests().size());
}

TEST_CASE("the chain is reached over TCP and over a local socket as well") {
  SimulatedChainOptions options;
  SECTION("TCP") { options.listen = "tcp:0"; }
  SECTION("local socket") {
    options.listen =
        "unix:" + (std::filesystem::temp_directory_path() / "tactbench-chain-").string() + std::to_string(::getpid());
  }
  check_arms_and_moves(options);
}
