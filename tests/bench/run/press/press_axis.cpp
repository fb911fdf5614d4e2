// The z axis on an ideal stage: when it polls, what halts it, and what a reading contains.
#include "bench/run/press/press_axis.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ForceSample;
using devices::fault_id_of;
using std::chrono::milliseconds;

TEST_CASE("press axis: a reading has z, both forms of the wrench and the sign of pressing") {
  IdealBed bed(spring(20.0));
  bed.stage.put(devices::Axis::kZ, 12.5);
  CHECK(bed.axis.find() == 12.5);
  bed.clock.wait_until(milliseconds(7));
  const ForceSample sample = bed.axis.sample(33);
  CHECK(sample.time == milliseconds(7));
  CHECK(sample.z_mm == 12.5);
  CHECK_FALSE(sample.moving);
  CHECK(sample.force_n == 10.0);
  CHECK(sample.wrench.force_n[2] == -10.0);
  CHECK(sample.raw[3] == 310.0);
  CHECK(bed.force.reads.back().records == 33);
  REQUIRE(bed.samples.size() == 1);
  CHECK(bed.samples[0].force_n == 10.0);
  bed.axis.event("a", "b");
  CHECK(bed.events == std::vector<std::pair<std::string, std::string>>{{"a", "b"}});
  bed.hooks.event = nullptr;
  bed.hooks.sample = nullptr;
  bed.axis.event("a", "b");
  CHECK(bed.axis.sample(1).force_n == 10.0);
}

TEST_CASE("press axis: the force limit is inclusive, applies in both directions, and NaN exceeds it") {
  const auto at = [](double force_n) {
    IdealBed bed([=](double) { return force_n; });
    const std::string id = fault_id_of([&] { (void)bed.axis.sample(1); });
    CHECK(bed.stage.halts == (id == "none" ? 0 : 1));
    return id;
  };
  CHECK(at(33.0) == "none");
  CHECK(at(-33.0) == "none");
  CHECK(at(std::nextafter(33.0, 34.0)) == "TB-PRESS-FORCE-LIMIT");
  CHECK(at(-33.1) == "TB-PRESS-FORCE-LIMIT");
  CHECK(at(std::numeric_limits<double>::quiet_NaN()) == "TB-PRESS-FORCE-LIMIT");
}

TEST_CASE("press axis: reads toward the specimen as often as the stiffest contact needs, away from it never") {
  IdealBed bed(spring(20.0));
  bed.stage.put(devices::Axis::kZ, 12.5);
  (void)bed.axis.find();
  (void)bed.axis.sample(1);  // 10 N
  bed.force.reads.clear();
  // 23 N more at 100 N/mm and 1 mm/s take 230 ms, 40 ms of them to hear and to stop.
  const ForceSample there = bed.axis.move_to(13.0, 1.0);
  REQUIRE(bed.force.reads.size() == 4);
  CHECK(bed.force.reads[0].time == milliseconds(190));
  CHECK(bed.force.reads[0].records == 10);
  CHECK(bed.force.reads[0].force_n == Approx(13.8));
  CHECK(bed.samples[1].moving);
  CHECK(bed.samples[1].z_mm == 12.5);                   // where z stood last
  CHECK(bed.force.reads[1].time == milliseconds(342));  // 19.2 N: 192 - 40
  CHECK(bed.force.reads[2].time.count() == Approx(463.6e6));
  CHECK(bed.force.reads[3].time == milliseconds(550));  // the way, and 50 ms to settle
  CHECK(bed.force.reads[3].records == 50);
  CHECK(there.force_n == Approx(20.0));
  CHECK(there.z_mm == 13.0);
  CHECK(bed.axis.z_mm() == 13.0);
  bed.force.reads.clear();
  bed.waits.clear();
  CHECK(bed.axis.move_to(12.0, 1.0).force_n == 0.0);
  CHECK(bed.force.reads.size() == 1);
  CHECK(bed.waits == std::vector<devices::Nanoseconds>{milliseconds(550 + 1050)});
}

TEST_CASE("press axis: near the limit it reads at the shortest interval, and last before the end of the move") {
  bench::PressOptions options = ideal_options();
  options.force_limit_n = 10.0;
  IdealBed bed([](double) { return 9.0; }, options);
  (void)bed.axis.find();
  (void)bed.axis.sample(1);
  bed.force.reads.clear();
  (void)bed.axis.move_to(0.11, 1.0);  // 1 N in 10 ms: looked at each 40 ms, 160 ms in all: no look at its very end
  REQUIRE(bed.force.reads.size() == 4);
  for (int i = 0; i < 3; ++i) CHECK(bed.force.reads[static_cast<std::size_t>(i)].time == milliseconds(40 * (i + 1)));
  CHECK(bed.force.reads[3].time == milliseconds(160));
  CHECK(bed.force.reads[3].records == 50);
}

TEST_CASE("press axis: any fault halts the stage once and is rethrown") {
  IdealBed bed([](double z_mm) { return z_mm > 12.2 ? 40.0 : 0.0; });
  bed.stage.put(devices::Axis::kZ, 12.0);
  (void)bed.axis.find();
  const auto beyond = devices::fault_of([&] { (void)bed.axis.move_to(13.0, 0.5); });
  REQUIRE(beyond);
  CHECK(beyond->id() == "TB-PRESS-FORCE-LIMIT");
  CHECK_THAT(beyond->what(), Catch::Contains(fmt::format("{:.3f} mm", bed.stage.z_mm())));  // its true position
  CHECK(bed.axis.z_mm() == bed.stage.z_mm());
  CHECK(bed.stage.halts == 1);
  CHECK(bed.stage.z_mm() < 12.6);
  bed.force.failures = 1;
  CHECK(fault_id_of([&] { (void)bed.axis.descend(14.0, 0.5); }) == "TB-FORCE-TEST");
  CHECK(bed.stage.halts == 2);
  bed.stage.homed = false;
  CHECK(fault_id_of([&] { (void)bed.axis.find(); }) == "TB-PRESS-NOT-HOMED");
}

TEST_CASE("press axis: a descent ends after two readings in contact, or at its end position") {
  IdealBed bed(spring(20.0));
  bed.stage.put(devices::Axis::kZ, 11.9);
  (void)bed.axis.find();
  CHECK(bed.axis.descend(14.0, 0.5));
  CHECK(bed.axis.z_mm() == Approx(12.02));  // 240 ms: 0.4 N
  CHECK(bed.clock.now() == milliseconds(240));
  CHECK(bed.force.reads.size() == 7);
  for (const IdealForce::Read& read : bed.force.reads) CHECK(read.records == 10);
  IdealBed exact([](double z_mm) { return z_mm >= 11.0 ? 0.1 : 0.0; });  // just a contact
  exact.stage.put(devices::Axis::kZ, 10.99);
  (void)exact.axis.find();
  CHECK(exact.axis.descend(14.0, 0.5));
  IdealBed less([](double) { return std::nextafter(0.1, 0.0); });
  less.stage.put(devices::Axis::kZ, 13.0);
  (void)less.axis.find();
  CHECK_FALSE(less.axis.descend(14.0, 0.5));
  CHECK(less.axis.z_mm() == 14.0);
  CHECK(less.clock.now() == milliseconds(2050));
  CHECK(less.waits.back() == milliseconds(2050));  // no look beyond the end
}
