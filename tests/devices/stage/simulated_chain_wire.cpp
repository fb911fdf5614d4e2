// What the simulated chain is told to do wrong, and which firmware the driver takes from it.
#include <catch2/catch.hpp>
#include <mutex>

#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

TEST_CASE("a stall holds its axis alone, from its time until it ends, and the axis ends short by what it missed") {
  ChainStall stall;
  std::mutex mutex;  // the chain asks on its own thread
  ZaberRig rig({}, {.stall = [&] {
                 const std::lock_guard lock(mutex);
                 return stall;
               }});
  rig.arm_and_home();
  const Nanoseconds begin = rig.clock.now();
  {
    const std::lock_guard lock(mutex);
    stall = {begin + 1s, begin + 4s, Axis::kY};
  }
  for (const Axis axis : {Axis::kX, Axis::kY})
    rig.stage.start_move_to(axis, Millimetres(10.0), MillimetresPerSecond(2.0));  // 5 s
  const auto y_at = [&](Nanoseconds after) {
    rig.clock.wait_until(begin + after);
    return rig.chain.position(Axis::kY).value();
  };
  const double early = y_at(900ms), held = y_at(1500ms), still = y_at(3500ms);
  CHECK(early > 1.0);
  CHECK(held >= early);
  CHECK(held < 2.1);
  CHECK(still == Approx(held).margin(1e-4));
  const double late = y_at(10s);
  CHECK(late == Approx(10.0 - 6.0).margin(0.1));  // free again for the rest of its move, 3 s of 2 mm/s behind
  CHECK(rig.chain.position(Axis::kX).value() == Approx(10.0).margin(1e-4));
}

TEST_CASE("identifying a Zaber stage accepts firmware 5.00 to 5.99, both included, and names others") {
  const auto [firmware, said] =
      GENERATE(table<std::int32_t, std::string>({{500, ""},
                                                 {599, ""},
                                                 {499, "firmware 4.99 answers, 5.00 to 5.99 is expected"},
                                                 {600, "firmware 6.00 answers, 5.00 to 5.99 is expected"}}));
  SimulatedChainOptions chain;
  chain.devices[0].firmware = firmware;
  ZaberRig rig(chain);
  const auto found = rig.stage.identify();
  REQUIRE(found.size() == 3);
  CHECK(found[0].present);
  if (said.empty()) CHECK(found[0].complaint.empty());
  CHECK_THAT(found[0].complaint, Catch::Contains(said));
}
