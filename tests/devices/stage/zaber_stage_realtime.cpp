// The simulated chain running by itself on a steady clock: ends of moves are reported unasked.
#include <catch2/catch.hpp>
#include <thread>

#include "devices/stage/zaber_retreat.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

SimulatedChainOptions free_running() {
  SimulatedChainOptions options;
  options.free_running = true;
  for (ChainDeviceOptions& device : options.devices) device.stands_at = Millimetres(0.05);
  return options;
}

}  // namespace

TEST_CASE("simulated Zaber chain: in real time it reports the end of homing to another client") {
  SteadyClock clock;
  const SimulatedChain chain(free_running(), clock);
  SerialAddress address;
  address.port = chain.address();
  const auto stream = open_serial(address);
  stream->write(encode_without_id({3, kHome, 0, 0}));
  std::array<std::uint8_t, 6> reply{};
  REQUIRE(stream->read(reply, 10s) == 6);
  CHECK(decode_without_id(reply) == ZaberFrame{3, kHome, 0, 0});
}

TEST_CASE("Zaber stage: homes, moves and is halted by another thread in real time") {
  ZaberRig<SteadyClock> rig(free_running());
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(0.5), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(0.5).margin(1e-4));
  rig.stage.start_move_to(Axis::kZ, Millimetres(50.0), MillimetresPerSecond(1.0));  // 50 s
  bool stands = false;
  std::thread other([&] { stands = rig.stage.halt(); });
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kZ); }) == "TB-STAGE-HALTED");
  other.join();
  CHECK(stands);
  CHECK(rig.chain.position(Axis::kZ).value() < 25.0);
}

namespace {

SimulatedChainOptions alive() {
  SimulatedChainOptions options;
  options.free_running = true;
  return options;
}

}  // namespace

TEST_CASE("Zaber retreat: stops moving axes, then backs z off, never below its home") {
  ZaberRig<SteadyClock> rig(alive());
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(3.0), std::nullopt);
  (void)rig.stage.wait(Axis::kZ);
  rig.stage.start_speed(Axis::kZ, MillimetresPerSecond(0.05));
  rig.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0));
  rig.stage.disarm();  // gives the line back; the axes continue
  const StageRetreat first = retreat(rig.connect(), paper_stage(), Millimetres(2.0), 10s);
  INFO(first.text);
  CHECK(first.stands);
  CHECK(first.backed_off);
  CHECK(rig.chain.position(Axis::kZ).value() > 0.5);
  CHECK(rig.chain.position(Axis::kZ).value() < 2.0);
  const double x = rig.chain.position(Axis::kX).value();
  const StageRetreat second = retreat(rig.connect(), paper_stage(), Millimetres(5.0), 10s);
  CHECK(second.backed_off);
  // The device counts whole microsteps: it says 0 while the last half of one is still to go.
  CHECK(rig.chain.position(Axis::kZ).value() < 0.001);
  CHECK(rig.chain.position(Axis::kX).value() == x);
}

TEST_CASE("Zaber retreat: a z axis that was never homed is stopped and not moved") {
  ZaberRig<SteadyClock> rig(alive());
  const StageRetreat result = retreat(rig.connect(), paper_stage(), Millimetres(2.0), 10s);
  CHECK(result.stands);
  CHECK_FALSE(result.backed_off);
  CHECK(rig.count(kMoving) == 0);
}
