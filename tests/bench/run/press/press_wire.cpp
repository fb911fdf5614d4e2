// The second platform over its wires: contact found, levels reached from one side, and what goes wrong on the way.

#include <catch2/catch.hpp>

#include <cmath>

#include "bench/run/press/press.h"
#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::PressOptions;
using bench::PressReading;
using devices::fault_id_of;

namespace {

constexpr double kRing[] = {2.0, 6.0, 10.0, 20.0, 30.0, 20.0, 10.0, 6.0, 2.0};
constexpr std::size_t kPeak = 4;
constexpr std::uint64_t kMostExchanges = 25;  // of a level without dwell

Branch branch_of(std::size_t level) { return level <= kPeak ? Branch::kLoading : Branch::kUnloading; }

// The paper's loop; checks that each level is met and that z never goes back within a branch.
void ring(PressRig& rig) {
  const PressOptions& options = rig.press->options();
  rig.press->tare();
  rig.press->move_xy(3.0, 4.0);
  (void)rig.press->approach();
  rig.stage.sent_mm.clear();
  double last_mm = rig.z_mm();
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < std::size(kRing); ++i) {
    INFO("level " << i << ", " << kRing[i] << " N");
    const std::uint64_t before = rig.exchanges();
    const PressReading reading = rig.go(kRing[i], branch_of(i), 0.0);
    CHECK_FALSE(reading.broken);
    CHECK(std::abs(reading.force_n - kRing[i]) <= options.tolerance(kRing[i]));
    most = std::max(most, rig.exchanges() - before);
    for (const double z_mm : rig.stage.sent_mm) {
      CHECK((branch_of(i) == Branch::kLoading ? z_mm > last_mm : z_mm < last_mm));
      last_mm = z_mm;
    }
    CHECK(rig.stage.sent_mm.size() == static_cast<std::size_t>(reading.moves));
    rig.stage.sent_mm.clear();
  }
  CHECK(most <= kMostExchanges);
  CHECK(rig.frames == static_cast<int>(std::size(kRing)));
  const bench::RetractProof proof = rig.press->retract();
  INFO(proof.text);
  CHECK(proof.verified);
}

}  // namespace

TEST_CASE("approach: the surface is found within 0.02 mm on stiff and soft contacts, with little force") {
  const double stiffness = GENERATE(5.0, 20.0, 80.0, 0.0);  // 0: soft at first, as cloth
  PressRig rig(stiffness > 0.0 ? spring(stiffness) : cloth(1.0, 30.0, 0.04, 0.015));
  rig.press->tare();
  const bench::ContactPoint contact = rig.press->approach();
  CHECK(std::abs(contact.z_mm - kSurfaceMm) <= contact.uncertainty_mm);
  CHECK(contact.uncertainty_mm < 0.04);
  if (stiffness <= 0.0) return;
  CHECK(std::abs(contact.z_mm - kSurfaceMm) < 0.02);
  CHECK(contact.max_force_n < 0.1 + bench::overshoot_n(0.5, 0.04, 0.02, stiffness) + 0.02);
  CHECK(rig.press->clear_z_mm() == 10.0);
  CHECK(rig.z_mm() - kSurfaceMm < 0.06);
}

TEST_CASE("press: the ring loop reaches every level from one side on elastic, stiffening and rubbing contacts") {
  // Elastic; cloth with friction and play; soft at first, then stiff; stiff.
  for (const ContactLaw& law :
       {spring(20.0), cloth(20.0, 10.0, 0.04, 0.01), cloth(1.0, 30.0, 0.02, 0.015), spring(80.0)}) {
    PressRig rig(law);
    ring(rig);
  }
}

TEST_CASE("press: a contact that stiffens during the servo breaks the branch, states the overshoot, takes no frame") {
  // 5 N/mm for 0.6 mm, then a wall.
  PressRig rig([](double z_mm) {
    const double depth_mm = std::max(0.0, z_mm - kSurfaceMm);
    return 5.0 * depth_mm + 25.0 * std::max(0.0, depth_mm - 0.6);
  });
  rig.press->tare();
  (void)rig.press->approach();
  CHECK_FALSE(rig.go(2.0, Branch::kLoading).broken);
  const PressReading reading = rig.go(6.0, Branch::kLoading);
  REQUIRE(reading.broken);
  CHECK(reading.broken->target_n == 6.0);
  CHECK(reading.broken->overshoot_n > rig.press->options().tolerance(6.0));
  CHECK(reading.broken->force_n == Approx(6.0 + reading.broken->overshoot_n));
  CHECK(rig.frames == 1);
  CHECK(rig.events.back() == "branch-broken");
  CHECK(rig.press->retract().verified);
  // Already beyond a level: nothing moves.
  (void)rig.press->approach();
  CHECK_FALSE(rig.go(2.0, Branch::kLoading).broken);
  rig.stage.sent_mm.clear();
  CHECK(rig.go(1.0, Branch::kLoading).broken);
  CHECK(rig.go(4.0, Branch::kUnloading).broken);
  CHECK(rig.stage.sent_mm.empty());
}

// Faults while z moves under force: each has its own error, and the axis stops before anyone is informed.

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
