// The Zaber driver against the simulated chain over a pseudo-terminal.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

constexpr double kStep = 0.0001;  // mm, no less than any microstep here

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

TEST_CASE("Zaber stage: homing moves an axis to its sensor in the expected time") {
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

TEST_CASE("Zaber stage: absolute and relative moves end at their targets, in the time of a trapezoidal profile") {
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

TEST_CASE("Zaber stage: two axes move at once, and their replies may come in any order") {
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

TEST_CASE("Zaber stage: stop brings a moving axis to rest short of its target") {
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

TEST_CASE("Zaber stage: an axis whose homing was refused is not homed, and is after the next attempt") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.chain.refuse_next(kHome, 1);
  CHECK(fault_id_of([&] { rig.stage.home(Axis::kY); }) == "TB-STAGE-REFUSED");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kY, Millimetres(3.0), {}); }) == "TB-STAGE-NOT-HOMED");
  rig.stage.home(Axis::kY);
  rig.stage.start_move_to(Axis::kY, Millimetres(3.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kY).value() == Approx(3.0).margin(kStep));
}

TEST_CASE("Zaber stage: a move that a power cycle interrupts is detected") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
  rig.chain.power_cycle();
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kZ); }) == "TB-STAGE-ASTRAY");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), {}); }) == "TB-STAGE-NOT-HOMED");
}

TEST_CASE("Zaber stage: after a damaged, cut or late reply the query is repeated and the move succeeds") {
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

TEST_CASE("Zaber stage: the chain is renumbered only on request") {
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

TEST_CASE("Zaber stage: an unexpected device is refused before its mode is written") {
  SimulatedChainOptions chain;
  SECTION("another model") { std::swap(chain.devices[0].device_id, chain.devices[2].device_id); }
  SECTION("firmware 6, whose units differ") { chain.devices[0].firmware = 606; }
  ZaberRig rig(chain);
  CHECK(fault_id_of([&] { rig.stage.arm(); }) == "TB-STAGE-WRONG-DEVICE");
  CHECK_FALSE(rig.stage.armed());
  CHECK(rig.count({kMode}) == 0);
}
