#include "devices/stage/zaber_retreat.h"

#include <catch2/catch.hpp>

#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

SimulatedChainOptions alive() {
  SimulatedChainOptions options;
  options.free_running = true;
  return options;
}

}  // namespace

TEST_CASE("zaber retreat: stops what moves, then backs z off, never below its home") {
  ZaberRig<SteadyClock> rig(alive());
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(3.0), std::nullopt);
  (void)rig.stage.wait(Axis::kZ);
  rig.stage.start_speed(Axis::kZ, MillimetresPerSecond(0.05));
  rig.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0));
  rig.stage.disarm();  // gives the line back; the axes continue
  const ZaberRetreat first = retreat(rig.connect(), paper_stage(), Millimetres(2.0), 10s);
  INFO(first.text);
  CHECK(first.stands);
  CHECK(first.backed_off);
  CHECK(rig.chain.position(Axis::kZ).value() > 0.5);
  CHECK(rig.chain.position(Axis::kZ).value() < 2.0);
  const double x = rig.chain.position(Axis::kX).value();
  const ZaberRetreat second = retreat(rig.connect(), paper_stage(), Millimetres(5.0), 10s);
  CHECK(second.backed_off);
  // The device counts whole microsteps: it says 0 while the last half of one is still to go.
  CHECK(rig.chain.position(Axis::kZ).value() < 0.001);
  CHECK(rig.chain.position(Axis::kX).value() == x);
}

TEST_CASE("zaber retreat: a z that was never homed is stopped and left where it is") {
  ZaberRig<SteadyClock> rig(alive());
  const ZaberRetreat result = retreat(rig.connect(), paper_stage(), Millimetres(2.0), 10s);
  CHECK(result.stands);
  CHECK_FALSE(result.backed_off);
  CHECK(rig.count(kMoving) == 0);
}
