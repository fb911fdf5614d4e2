// The Zaber driver's promises beyond the laws of every actuator (zaber_actuator_wire.cpp joins it to those).
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/stage/zaber_rig.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

// Every command, each expected to end in `fault`.
void check_all_refused(Stage& stage, const std::string& fault) {
  CHECK(fault_id_of([&] { stage.home(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt); }) == fault);
  CHECK(fault_id_of([&] { stage.start_move_by(Axis::kX, Millimetres(1.0), std::nullopt); }) == fault);
  CHECK(fault_id_of([&] { stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.wait(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.stop(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.state(Axis::kX); }) == fault);
}

}  // namespace

TEST_CASE("Zaber contract: no axis moves before it is homed or after a power loss") {
  ZaberRig rig;
  rig.stage.arm();
  const auto before = rig.chain.bytes_received();
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(fault_id_of([&] { rig.stage.start_move_by(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(fault_id_of([&] { rig.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); }) == "TB-STAGE-NOT-HOMED");
  CHECK(rig.chain.bytes_received() == before);
  rig.stage.home(Axis::kX);
  rig.chain.power_cycle();
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(rig.count({kMoveAbsolute, kMoveRelative, kConstantSpeed}) == 0);
}

TEST_CASE("Zaber contract: on a silent connection the query is repeated once, then a timeout fault disarms the stage") {
  SimulatedChainFaults faults;
  faults.silent_after_requests = GENERATE(0L, 7L, 60L, 75L);
  ZaberRig rig({}, faults, impatient_stage());
  const auto all = [&] {
    rig.arm_and_home();
    rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
    (void)rig.stage.wait(Axis::kZ);
  };
  CHECK(fault_id_of(all) == "TB-STAGE-TIMEOUT");
  CHECK_FALSE(rig.stage.armed());
  // The query whose reply was lost was sent twice: process time has advanced by both waits.
  CHECK(rig.clock.now() >= 2 * impatient_stage().reply_timeout);
  check_all_refused(rig.stage, "TB-STAGE-NOT-ARMED");
}

TEST_CASE("Zaber contract: unplugging during any exchange is a lost connection, never a timeout") {
  SimulatedChainFaults faults;
  faults.unplug_after_requests = GENERATE(0L, 9L, 33L, 60L, 80L);
  ZaberRig rig({}, faults);
  CHECK(fault_id_of([&] {
          rig.arm_and_home();
          rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
          (void)rig.stage.wait(Axis::kZ);
        }) == "TB-SERIAL-LOST");
  CHECK_FALSE(rig.stage.armed());
}

TEST_CASE("Zaber contract: halt stops every axis from any state, twice, and commands are refused until arming") {
  ZaberRig rig;
  CHECK(rig.stage.halt());  // never armed: it opens the line by itself
  CHECK(rig.count(kMoving) == 0);
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(40.0), std::nullopt);
  rig.stage.start_speed(Axis::kZ, MillimetresPerSecond(8.0));
  rig.clock.wait_until(rig.clock.now() + 1s);
  CHECK(rig.stage.halt());
  CHECK_FALSE(rig.stage.armed());
  const Millimetres x = rig.chain.position(Axis::kX);
  const Millimetres z = rig.chain.position(Axis::kZ);
  CHECK(x.value() < 6.0);
  CHECK(z.value() < 12.0);
  rig.clock.wait_until(rig.clock.now() + 100s);
  CHECK(rig.chain.position(Axis::kX) == x);
  CHECK(rig.chain.position(Axis::kZ) == z);
  CHECK(rig.stage.halt());
  const auto before = rig.chain.bytes_received();
  check_all_refused(rig.stage, "TB-STAGE-HALTED");
  CHECK(rig.chain.bytes_received() == before);
  rig.stage.arm();
  rig.stage.start_move_to(Axis::kZ, Millimetres(0.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(0.0).margin(1e-4));
}

TEST_CASE("Zaber contract: halt during homing succeeds, whether or not the device refuses stops while homing") {
  SimulatedChainOptions options;
  options.devices[2].stands_at = Millimetres(1.5);
  options.devices[2].refuses_stop_while_homing = GENERATE(false, true);
  ZaberRig rig(options);
  rig.stage.arm();
  // Another program's homing: the driver's own would block the thread that turns the clock.
  {
    rig.stage.disarm();
    const auto stream = rig.connect();
    stream->write(encode({3, kHome, 0, 1}));
    stream->write(encode({3, kStatus, 0, 2}));
    std::array<std::uint8_t, 6> reply{};
    REQUIRE(stream->read(reply, 5s) == 6);
    REQUIRE(decode(reply).data == kZaberHoming);
  }
  CHECK(rig.stage.halt());
}

TEST_CASE("Zaber contract: half a frame left on the line does not corrupt the halt") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(40.0), std::nullopt);
  if (GENERATE(false, true)) rig.stage.disarm();
  const int intruder = ::open(rig.chain.address().c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  const std::array<std::uint8_t, 4> half{3, 20, 0, 0};
  REQUIRE(::write(intruder, half.data(), half.size()) == 4);
  while (rig.chain.bytes_received() % 6 != 4) std::this_thread::sleep_for(1ms);  // a busy machine reads them late
  CHECK(rig.stage.halt());
  ::close(intruder);
  // Joined to it the first bytes of the stop would have made another move.
  CHECK(rig.count(kMoving) == 4);
  CHECK(rig.chain.position(Axis::kZ).value() < 39.0);
}

TEST_CASE("Zaber contract: halt from another thread ends a wait in progress") {
  ZaberStageOptions options = paper_stage();
  options.halt_timeout = 100ms;
  ZaberRig rig({}, {}, options);
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(60.0), MillimetresPerSecond(0.001));  // 60 000 s
  const std::size_t before = rig.chain.requests().size();
  std::thread other([&] {
    while (rig.chain.requests().size() < before + 20) std::this_thread::yield();
    (void)rig.stage.halt();  // the clock may not advance meanwhile, so the answer may be false
  });
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kX); }) == "TB-STAGE-HALTED");
  other.join();
  CHECK(rig.stage.halt());
  CHECK(rig.chain.position(Axis::kX).value() < 59.0);
}

TEST_CASE("Zaber contract: a command is refused at once while a halt still waits for the axes") {
  ReadyStage alone;
  std::atomic<bool> halting{false}, refused{false}, refused_meanwhile{false};
  alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
    if (frame.command == kStatus && frame.device == 1) {
      halting = true;
      const auto end = std::chrono::steady_clock::now() + kPatient;
      while (!refused && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
      refused_meanwhile = refused.load();
    }
    return std::nullopt;
  };
  bool stands = false;
  std::thread other([&] { stands = alone.stage.halt(); });
  while (!halting) std::this_thread::yield();
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "TB-STAGE-HALTED");
  refused = true;
  other.join();
  CHECK(stands);
  CHECK(refused_meanwhile);
  alone.stage.arm();
  CHECK(alone.stage.armed());
}

TEST_CASE("Zaber contract: a halt that waits for the line interrupts a sequence of queries") {
  bool refused = false;
  // The halt's thread may start late, and then has nothing to break off.
  const auto end = std::chrono::steady_clock::now() + kPatient;
  while (!refused && std::chrono::steady_clock::now() < end) {
    StageAlone alone;
    alone.stage.arm();
    std::thread other;
    alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
      if (frame.command == kDeviceId && !other.joinable()) other = std::thread([&] { (void)alone.stage.halt(); });
      if (frame.device != 0) std::this_thread::sleep_for(2ms);
      return std::nullopt;
    };
    const auto fault = fault_of([&] { (void)alone.stage.identify(); });
    other.join();
    refused = fault && fault->id() == "TB-STAGE-HALTED";
    CHECK_FALSE(alone.stage.armed());
  }
  CHECK(refused);
}
