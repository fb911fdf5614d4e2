// The search for contact on an ideal stage: where it reads the force, how often, and how its numbers are derived.
#include "bench/run/press/approach.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ContactPoint;
using devices::fault_id_of;
using std::chrono::milliseconds;

TEST_CASE("approach on an ideal stage: descent, back-off and steps agree with hand-computed values") {
  IdealBed bed(spring(20.0));
  const ContactPoint contact = bench::find_contact(bed.axis, 10.0);
  // 0.5 mm/s from 10 mm, a look each 40 ms: felt at 4.04 s, 12.02 mm, 0.4 N. Back 0.1 mm, then steps of 0.01 mm; the
  // first two readings of 0.1 N and more are 0.2 N at 12.01 mm and 0.4 N at 12.02 mm.
  CHECK(contact.coarse_z_mm == Approx(12.02));
  CHECK(contact.max_force_n == Approx(0.4));
  CHECK(contact.stiffness_n_per_mm == Approx(20.0));
  CHECK(contact.z_mm == Approx(12.0));
  CHECK(contact.uncertainty_mm == Approx(0.005 + 0.01));
  CHECK(contact.reading.force_n == Approx(0.4));
  CHECK(contact.reading.z_mm == Approx(12.02));
  CHECK_FALSE(contact.reading.moving);
  std::vector<double> sent{10.0, 14.0, 11.92};
  for (int i = 1; i <= 10; ++i) sent.push_back(11.92 + 0.01 * i);
  REQUIRE(bed.stage.sent_mm.size() == sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) CHECK(bed.stage.sent_mm[i] == Approx(sent[i]).epsilon(1e-12));
  CHECK(bed.stage.speeds[0] == 4.0);
  CHECK(bed.stage.speeds[1] == 0.5);
  for (std::size_t i = 2; i < sent.size(); ++i) CHECK(bed.stage.speeds[i] == 0.05);
  // One sample, 64 looks on 10 mm of free way (one each 40 ms, the last at its end), a sample there, 102 looks of the
  // search, the touch, two samples, and one after each of the ten steps.
  CHECK(bed.force.reads.size() == 1 + 64 + 1 + 102 + 1 + 1 + 1 + 10);
  CHECK(bed.force.reads.front().records == 50);
  CHECK(bed.force.reads[1].records == 10);
  CHECK(bed.force.reads[1].time == milliseconds(40));
  CHECK(bed.force.reads[65].records == 50);
  CHECK(bed.force.reads[65].time == milliseconds(2550));
  CHECK(bed.force.reads[66].time == milliseconds(2590));
  CHECK(bed.force.reads[168].records == 10);  // the touch
  CHECK(bed.clock.now() == milliseconds(2550 + 4040 + 2050 + 10 * 250));
  CHECK(bed.stage.halts == 0);
}

TEST_CASE("approach on an ideal stage: if z is at or beyond clear_z_mm, the search starts there without moving back") {
  IdealBed bed(spring(20.0));
  bed.stage.put(devices::Axis::kZ, 11.0);
  const ContactPoint contact = bench::find_contact(bed.axis, 10.0);
  CHECK(bed.stage.sent_mm.front() == 14.0);
  CHECK(contact.z_mm == Approx(12.0));
  IdealBed there(spring(20.0));
  there.stage.put(devices::Axis::kZ, 10.0);
  (void)bench::find_contact(there.axis, 10.0);
  CHECK(there.stage.sent_mm.front() == 14.0);
}

TEST_CASE(
    "approach on an ideal stage: a force below the contact limit is allowed before the search, the limit is not") {
  const auto at = [](double before_n) {
    IdealBed bed([=](double z_mm) { return z_mm < 5.0 ? before_n : spring(20.0)(z_mm); });
    return fault_id_of([&] { (void)bench::find_contact(bed.axis, 10.0); });
  };
  CHECK(at(0.1) == "TB-PRESS-NOT-FREE");
  CHECK(at(-0.1) == "TB-PRESS-NOT-FREE");
  CHECK(at(std::nextafter(0.1, 0.0)) == "none");
  CHECK(at(-0.09) == "none");
  // After the way to clear the same holds.
  IdealBed at_its_end([](double z_mm) { return z_mm > 9.9999 ? 0.15 : 0.0; });
  check_press_fault([&] { (void)bench::find_contact(at_its_end.axis, 10.0); }, "TB-PRESS-NOT-FREE",
                    {"0.15 N", "10.000 mm", "0.1 N"});
  IdealBed lost(spring(20.0));
  lost.stage.homed = false;
  CHECK(fault_id_of([&] { (void)bench::find_contact(lost.axis, 10.0); }) == "TB-PRESS-NOT-HOMED");
  CHECK(lost.stage.sent_mm.empty());
}

TEST_CASE("approach on an ideal stage: z stops at an object on the way to clear, within the force limit") {
  for (const double surface_mm : {0.0, 0.05, 3.0, 9.0, 9.8}) {
    for (const double stiffness : {1.0, 20.0, 100.0}) {
      bench::PressOptions fast = ideal_options();
      fast.travel_mm_per_s = 8.0;
      IdealBed bed([=](double z_mm) { return stiffness * std::max(0.0, z_mm - surface_mm); }, fast);
      INFO(stiffness << " N/mm at " << surface_mm << " mm");
      CHECK(fault_id_of([&] { (void)bench::find_contact(bed.axis, 10.0); }) == "TB-PRESS-NOT-FREE");
      CHECK(bed.stage.z_mm() > surface_mm);
      CHECK(bed.stage.z_mm() < surface_mm + 0.5);
      CHECK(bed.axis.z_mm() == bed.stage.z_mm());
      for (const IdealForce::Read& read : bed.force.reads) CHECK(read.force_n < fast.force_limit_n);
      CHECK(bed.stage.speeds.front() <= 33.0 / (100.0 * 0.08));  // a look, and what sensor and stage need to react
    }
  }
}

TEST_CASE("approach on an ideal stage: backs off up to four times, twice as far each time, until the contact is lost") {
  // Cloth that clings: after the touch the force stays until z is `free_mm` off it.
  const auto clinging = [](double free_mm, double stays_n) {
    return [=, deepest = 0.0](double z_mm) mutable {
      deepest = std::max(deepest, z_mm);
      const double pressed = 20.0 * std::max(0.0, z_mm - 12.0);
      return deepest > 12.0 && z_mm > deepest - free_mm ? std::max(stays_n, pressed) : pressed;
    };
  };
  const auto backed = [&](double free_mm, double stays_n, std::vector<double>& sent) {
    IdealBed bed(clinging(free_mm, stays_n));
    const std::string id = fault_id_of([&] { (void)bench::find_contact(bed.axis, 10.0); });
    sent.assign(bed.stage.sent_mm.begin() + 2, bed.stage.sent_mm.end());
    return id;
  };
  std::vector<double> sent;
  // 0.1, 0.3, 0.7 and 1.5 mm off in all.
  CHECK(backed(1.6, 0.06, sent) == "TB-PRESS-NOT-FREE");
  REQUIRE(sent.size() == 4);
  CHECK(sent[0] == Approx(11.92));
  CHECK(sent[1] == Approx(11.72));
  CHECK(sent[2] == Approx(11.32));
  CHECK(sent[3] == Approx(10.52));
  CHECK(backed(0.05, 0.06, sent) == "none");
  CHECK(sent[1] > sent[0]);
  CHECK(backed(1.6, 0.05, sent) == "TB-PRESS-NOT-FREE");
  (void)backed(1.6, 0.049, sent);
  CHECK(sent[1] > sent[0]);
}

TEST_CASE(
    "approach on an ideal stage: without contact it ends at the deepest z, or a back-off beyond the first touch") {
  IdealBed nothing([](double) { return 0.0; });
  check_press_fault([&] { (void)bench::find_contact(nothing.axis, 10.0); }, "TB-PRESS-NO-CONTACT",
                    {"0.000", "14.000 mm", "0.1 N"});
  CHECK(nothing.stage.z_mm() == 14.0);
  // The object of the first touch is gone: it is searched up to 0.1 mm further, in steps.
  IdealBed gone(spring(20.0));
  int looks = 0;
  gone.force.law = [&looks](double z_mm) { return z_mm > 12.0 && ++looks <= 3 ? 0.4 : 0.0; };
  CHECK(fault_id_of([&] { (void)bench::find_contact(gone.axis, 10.0); }) == "TB-PRESS-NO-CONTACT");
  CHECK(gone.stage.z_mm() == Approx(12.12).margin(0.0051));
  // No step goes beyond the deepest z.
  bench::PressOptions shallow = ideal_options();
  shallow.max_z_mm = 12.025;
  IdealBed edge(spring(20.0), shallow);
  looks = 0;
  edge.force.law = [&looks](double z_mm) { return z_mm > 12.0 && ++looks <= 3 ? 0.4 : 0.0; };
  CHECK(fault_id_of([&] { (void)bench::find_contact(edge.axis, 10.0); }) == "TB-PRESS-NO-CONTACT");
  CHECK(edge.stage.z_mm() <= 12.025);
  CHECK(edge.stage.z_mm() > 12.014);
}

TEST_CASE("approach on an ideal stage: a single reading is not a contact, and the sign of the force is checked") {
  int looks = 0;
  IdealBed shock(spring(20.0));
  shock.force.law = [&looks](double z_mm) {  // one reading of 0.4 N in the air
    if (z_mm > 11.0 && ++looks == 1) return 0.4;
    return 20.0 * std::max(0.0, z_mm - 12.0);
  };
  CHECK(bench::find_contact(shock.axis, 10.0).coarse_z_mm == Approx(12.02));
  IdealBed pulls([](double z_mm) { return -20.0 * std::max(0.0, z_mm - 12.0); });
  check_press_fault([&] { (void)bench::find_contact(pulls.axis, 10.0); }, "TB-PRESS-SIGN", {"0.40 N"});
}

TEST_CASE("approach on an ideal stage: stiffness stays within its limits, the greatest force on the way is reported") {
  bench::PressOptions narrow = ideal_options();
  narrow.stiffest_n_per_mm = 15.0;
  IdealBed stiff(spring(20.0), narrow);
  const ContactPoint hard = bench::find_contact(stiff.axis, 10.0);
  CHECK(hard.stiffness_n_per_mm == 15.0);
  CHECK(hard.z_mm == Approx(12.01 - 0.2 / 15.0));
  narrow.softest_n_per_mm = 30.0;
  narrow.stiffest_n_per_mm = 100.0;
  IdealBed soft(spring(20.0), narrow);
  CHECK(bench::find_contact(soft.axis, 10.0).stiffness_n_per_mm == 30.0);
  // A first touch that is harder than what follows is kept.
  int looks = 0;
  IdealBed shocked(spring(20.0));
  shocked.force.law = [&looks](double z_mm) {
    const double force_n = 20.0 * std::max(0.0, z_mm - 12.0);
    return force_n > 0.0 && ++looks <= 3 ? 3.0 * force_n : force_n;
  };
  CHECK(bench::find_contact(shocked.axis, 10.0).max_force_n == Approx(1.2));
}
