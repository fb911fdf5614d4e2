// The second platform over its wires: contact found, levels reached from one side, and what goes wrong on the way.
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/rig/rig.h"
#include "bench/run/press/press_preflight.h"
#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::PressOptions;
using bench::PressReading;
using devices::Axis;
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

TEST_CASE("approach: the surface is found within 0.02 mm, stiff or soft, and hardly pressed") {
  const double stiffness = GENERATE(5.0, 20.0, 80.0);
  PressRig rig(elastic(stiffness));
  rig.press->tare();
  const bench::ContactPoint contact = rig.press->approach();
  CHECK(std::abs(contact.z_mm - kSurfaceMm) < 0.02);
  CHECK(std::abs(contact.z_mm - kSurfaceMm) <= contact.uncertainty_mm);
  CHECK(contact.uncertainty_mm < 0.04);
  CHECK(contact.greatest_n < 0.1 + bench::overshoot_n(0.5, 0.04, 0.02, stiffness) + 0.02);
  CHECK(rig.press->clear_z_mm() == 10.0);
  CHECK(rig.z_mm() - kSurfaceMm < 0.06);
}

TEST_CASE("approach: for a soft contact the uncertainty covers the error of the surface") {
  PressRig rig(cloth(1.0, 30.0, 0.04, 0.015));
  rig.press->tare();
  const bench::ContactPoint contact = rig.press->approach();
  CHECK(std::abs(contact.z_mm - kSurfaceMm) <= contact.uncertainty_mm);
  CHECK(contact.uncertainty_mm < 0.04);
}

TEST_CASE("press: the ring's loop meets every level from one side on elastic, stiffening and rubbing contacts") {
  SECTION("elastic") {
    PressRig rig(elastic(20.0));
    ring(rig);
  }
  SECTION("cloth with friction and play") {
    PressRig rig(cloth(20.0, 10.0, 0.04, 0.01));
    ring(rig);
  }
  SECTION("soft at first, then stiff") {
    PressRig rig(cloth(1.0, 30.0, 0.02, 0.015));
    ring(rig);
  }
  SECTION("stiff") {
    PressRig rig(elastic(80.0));
    ring(rig);
  }
}

TEST_CASE("press: small turns inside a loop are met from one side too") {
  PressRig rig(cloth(20.0, 10.0, 0.04, 0.01));
  rig.press->tare();
  (void)rig.press->approach();
  double last_n = 0.0;
  for (const double force_n : {10.0, 9.0, 11.0, 10.5, 25.0, 24.0, 3.0, 4.0}) {
    INFO(force_n);
    const PressReading reading = rig.go(force_n, force_n > last_n ? Branch::kLoading : Branch::kUnloading);
    CHECK_FALSE(reading.broken);
    CHECK(std::abs(reading.force_n - force_n) <= rig.press->options().tolerance(force_n));
    last_n = force_n;
  }
}

TEST_CASE("press: on the simulated rig of the bench file, with its own contact") {
  bench::Rig rig(small_request().bench);
  rig.stage()->arm();
  devices::ForceSensor& force = rig.open_force();
  PressOptions options = bench::press_options(rig.config());
  options.clear_z_mm = 28.0;
  bench::PressHooks hooks;
  hooks.wait = [&](devices::Nanoseconds time) { rig.clock().wait_until(time); };
  bench::Press press(*rig.stage(), force, rig.clock(), options, hooks);
  press.home();
  CHECK_FALSE(press.tare().drift);
  press.move_xy(30.0, 30.0);
  const bench::ContactPoint contact = press.approach();
  CHECK(std::abs(contact.z_mm - 30.0) < 0.02);
  for (std::size_t i = 0; i < std::size(kRing); ++i) {
    const std::uint64_t before = rig.stage()->exchanges() + force.exchanges();
    const PressReading reading = press.press({kRing[i], branch_of(i), 1.0, i % 2 == 0}, [] {});
    INFO("level " << i << ", " << reading.moves << " moves");
    CHECK_FALSE(reading.broken);
    CHECK(std::abs(reading.start.force_n - kRing[i]) <= options.tolerance(kRing[i]));
    CHECK(rig.stage()->exchanges() + force.exchanges() - before <= kMostExchanges + 12);
  }
  CHECK(press.retract().verified);
  const bench::TareReading tare = press.tare();
  REQUIRE(tare.drift);
  CHECK(std::abs(tare.drift->force_n[2]) < 0.02);
}

TEST_CASE("press: a contact that stiffens under the servo breaks the branch, with by how much, and takes no frame") {
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

TEST_CASE(
    "press: at a held position the force relaxes and the change is reported, at a held force z never moves back") {
  const bool hold_force = GENERATE(false, true);
  // Gives way a little with every record that is taken, as a slow fabric would with time.
  PressRig rig([sunk_mm = 0.0](double z_mm) mutable {
    const double depth_mm = std::max(0.0, z_mm - kSurfaceMm - sunk_mm);
    sunk_mm += 2e-5 * depth_mm;
    return 20.0 * depth_mm;
  });
  rig.press->tare();
  (void)rig.press->approach();
  rig.stage.sent_mm.clear();
  const PressReading reading = rig.go(10.0, Branch::kLoading, 20.0, hold_force);
  REQUIRE_FALSE(reading.broken);
  const double tolerance = rig.press->options().tolerance(10.0);
  for (std::size_t i = 1; i < rig.stage.sent_mm.size(); ++i) {
    CHECK(rig.stage.sent_mm[i] > rig.stage.sent_mm[i - 1]);
  }
  CHECK(reading.relaxation_n == reading.start.force_n - reading.before.force_n);
  if (hold_force) {
    CHECK(std::abs(reading.force_n - 10.0) <= tolerance);
  } else {
    CHECK(reading.relaxation_n > tolerance);
    CHECK(reading.z_mm == reading.start.z_mm);
  }
  CHECK((reading.before.time - reading.in_band_since) >= std::chrono::seconds(20));
  CHECK(reading.wrench.force_n[2] == Approx(-reading.force_n));
}

TEST_CASE("press: steps in the wrong order are refused and nothing moves") {
  PressRig rig(elastic(20.0));
  rig.press->tare();
  CHECK(fault_id_of([&] { (void)rig.go(2.0, Branch::kLoading); }) == "TB-PRESS-NO-APPROACH");
  (void)rig.press->approach();
  CHECK_FALSE(rig.go(6.0, Branch::kLoading).broken);
  const double z_mm = rig.z_mm();
  CHECK(fault_id_of([&] { rig.press->move_xy(5.0, 5.0); }) == "TB-PRESS-NOT-CLEAR");
  CHECK(fault_id_of([&] { (void)rig.press->tare(); }) == "TB-PRESS-NOT-CLEAR");
  CHECK(rig.z_mm() == z_mm);
  CHECK(rig.press->retract().verified);
  CHECK(fault_id_of([&] { rig.press->move_xy(5.0, 5.0); }) == "none");
  CHECK(fault_id_of([&] { (void)rig.go(2.0, Branch::kLoading); }) == "TB-PRESS-NO-APPROACH");
}
