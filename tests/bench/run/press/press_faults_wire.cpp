// Faults while z moves under force: each has its own error, and the axis stops before anyone is informed.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::PressOptions;
using devices::fault_id_of;

TEST_CASE("press: the force limit halts the stage during a move") {
  PressOptions options = ideal_options();
  options.force_limit_n = 12.0;
  // Soft, then a wall that no step expects.
  PressRig rig(
      [](double z_mm) {
        const double depth_mm = std::max(0.0, z_mm - kSurfaceMm);
        return 1.0 * depth_mm + 90.0 * std::max(0.0, depth_mm - 1.2);
      },
      options);
  (void)rig.press->approach();
  const int before = rig.stage.halts;
  CHECK(fault_id_of([&] { (void)rig.go(11.0, Branch::kLoading); }) == "TB-PRESS-FORCE-LIMIT");
  CHECK(rig.stage.halts == before + 1);
  CHECK(rig.stands());
  // The force that the preflight computes for the greatest stiffness is not exceeded.
  double max_force_n = 0.0;
  for (const bench::ForceSample& sample : rig.samples) max_force_n = std::max(max_force_n, sample.force_n);
  CHECK(max_force_n <= 12.0 + 100.0 * options.servo_mm_per_s * 2.0 * options.poll_interval_s);
  CHECK(rig.press->retract().verified);
}

TEST_CASE("press: a silent sensor, an unplugged stage and a stop request leave the axis at rest") {
  SECTION("the sensor falls silent while z goes down") {
    PressRig rig(spring(20.0), ideal_options(), {.silent_after_records = 800});
    CHECK(fault_id_of([&] { (void)rig.press->approach(); }) == "TB-FORCE-TIMEOUT");
    CHECK(rig.stage.halts == 1);
    CHECK(rig.z_mm() > 10.0);
    CHECK(rig.stands());
    const bench::RetractProof proof = rig.press->retract();
    INFO(proof.text);
    CHECK_FALSE(proof.verified);  // z is clear, but no reading shows that there is no force
    CHECK_FALSE(proof.force_n);
    REQUIRE(proof.z_mm);
    CHECK(*proof.z_mm == Approx(10.0).margin(1e-3));
  }
  SECTION("the stage is unplugged in contact") {
    PressRig rig(spring(20.0));
    (void)rig.press->approach();
    CHECK_FALSE(rig.go(6.0, Branch::kLoading).broken);
    rig.zaber.chain.unplug();
    CHECK_THAT(fault_id_of([&] { (void)rig.go(10.0, Branch::kLoading); }), Catch::StartsWith("TB-SERIAL"));
    const bench::RetractProof proof = rig.press->retract();
    INFO(proof.text);
    CHECK_FALSE(proof.verified);
    CHECK_FALSE(proof.halted);
    CHECK_THAT(proof.text, Catch::StartsWith("NOT SAFE"));
    rig.zaber.chain.plug_in();
    CHECK(rig.press->retract().verified);
  }
  SECTION("a request to stop comes from the wait") {
    PressRig rig(spring(20.0));
    int waits = 0;
    rig.on_wait = [&] {
      if (++waits >= 90) throw std::runtime_error("stop");
    };
    CHECK_THROWS_WITH(rig.press->approach(), "stop");
    CHECK(rig.stands());
    CHECK(rig.press->retract().verified);  // though each wait throws
    CHECK(rig.z_mm() == Approx(10.0).margin(1e-3));
  }
}
