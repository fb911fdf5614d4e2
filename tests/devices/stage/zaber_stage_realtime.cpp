// The simulated chain running by itself on a steady clock: ends of moves are reported unasked.
#include <catch2/catch.hpp>
#include <thread>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/zaber_rig.h"

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

TEST_CASE("a chain that runs by itself reports the end of a move to a foreign client") {
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

TEST_CASE("a real-time stage homes, moves and is halted by another thread") {
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
