// The search for contact on an ideal stage: where it reads the force, how often, and how its numbers are derived.

#include "bench/run/press/approach.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "bench/run/press/force_servo.h"
#include "bench/run/press/press_axis.h"
#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::ContactPoint;
using bench::ForceSample;
using bench::PressOptions;
using bench::ServoResult;
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

// The servo's steps to the last digit, worked out apart from the program by the rules that force_servo.h states, on
// contacts whose law is known: each rule decides in one of them.

namespace {

struct ServoBed : IdealBed {
  explicit ServoBed(IdealForce::Law law, const PressOptions& given = ideal_options())
      : IdealBed(std::move(law), given), servo(axis), contact(bench::find_contact(axis, 10.0)) {
    servo.begin(contact);
  }
  // Goes there; z of every move.
  std::vector<double> steps(double force_n, Branch branch) {
    stage.sent_mm.clear();
    last = servo.to(force_n, branch, options.tolerance(force_n));
    CHECK(last.moves == static_cast<int>(stage.sent_mm.size()));
    CHECK(last.reading.z_mm == stage.sent_mm.back());
    return stage.sent_mm;
  }
  bench::ForceServo servo;
  bench::ContactPoint contact;
  ServoResult last;
};

void check_steps(const std::vector<double>& made, const std::vector<double>& expected) {
  REQUIRE(made.size() == expected.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    INFO("move " << i);
    CHECK(made[i] == Approx(expected[i]).epsilon(0.0).margin(2e-9));
  }
}

IdealForce::Law square(double a, double b) {
  return [=](double z_mm) {
    const double depth = std::max(0.0, z_mm - 12.0);
    return a * depth + b * depth * depth;
  };
}

}  // namespace

TEST_CASE("force servo: steps on a linear contact, loading and unloading") {
  ServoBed bed(spring(20.0));
  check_steps(bed.steps(2.0, Branch::kLoading), {12.044595018, 12.07949854, 12.096679031, 12.099906422});
  check_steps(bed.steps(6.0, Branch::kLoading), {12.230729618, 12.287742705, 12.299617068});
  check_steps(bed.steps(30.0, Branch::kLoading), {12.691367757, 13.203278105, 13.45305437, 13.498712771});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(20.0));
  check_steps(bed.steps(20.0, Branch::kUnloading), {13.249540275, 13.049965706, 13.001808503});
  check_steps(bed.steps(2.0, Branch::kUnloading), {12.217627196, 12.102588374, 12.100008706});
  CHECK_FALSE(bed.last.broken);
  CHECK(bed.last.reading.force_n == Approx(20.0 * 0.100008706).margin(1e-7));
  for (const double speed : bed.stage.speeds) CHECK((speed == 4.0 || speed == 0.5 || speed == 0.05));
  CHECK(bed.stage.speeds.back() == 0.05);
}

TEST_CASE("force servo: steps on a contact that stiffens with force, and a small reversal inside the loop") {
  ServoBed bed(square(5.0, 30.0));
  check_steps(bed.steps(2.0, Branch::kLoading), {12.063487064, 12.121353329, 12.180224468, 12.187912914});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(16.04412148036396));
  check_steps(bed.steps(10.0, Branch::kLoading), {12.341800645, 12.486886531, 12.499893064});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(34.60338786441161));
  check_steps(bed.steps(30.0, Branch::kLoading), {12.84483887, 12.920423495});
  check_steps(bed.steps(10.0, Branch::kUnloading), {12.710717604, 12.579792635, 12.516488806, 12.501587189});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(35.542279836564795));
  check_steps(bed.steps(12.0, Branch::kLoading),
              {12.520454258, 12.529856322, 12.538937045, 12.550340559, 12.554360439});
  check_steps(bed.steps(1.0, Branch::kUnloading),
              {12.370978239, 12.250442879, 12.169301573, 12.131922431, 12.119615869});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(12.546148975090222));
}

TEST_CASE("force servo: steps on a contact that begins softly") {
  ServoBed bed(square(1.0, 30.0));
  check_steps(bed.steps(2.0, Branch::kLoading), {12.108046083, 12.185154723, 12.235759634, 12.241932166});
  check_steps(bed.steps(30.0, Branch::kLoading), {12.396913683, 12.649246009, 12.942178901, 12.982901589});
  check_steps(bed.steps(6.0, Branch::kUnloading),
              {12.727967498, 12.560799238, 12.468410145, 12.437124059, 12.431276699});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(27.052022731736827));
}

TEST_CASE("force servo: after a reversal the backlash is subtracted from the travel that changed the force") {
  ServoBed bed([tip = 0.0](double z_mm) mutable {  // the tip follows z within 15 micrometres
    tip = std::clamp(tip, z_mm - 0.0075, z_mm + 0.0075);
    return 20.0 * std::max(0.0, tip + 0.0075 - 12.0);
  });
  (void)bed.steps(2.0, Branch::kLoading);
  (void)bed.steps(6.0, Branch::kLoading);
  check_steps(bed.steps(4.0, Branch::kUnloading), {12.249863239, 12.201575041, 12.185811625});
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(20.0));
  check_steps(bed.steps(5.0, Branch::kLoading), {12.206602491, 12.236303729, 12.248528974});
}

TEST_CASE("force servo: without a response the stiffness is halved, and a step is at most three times the last") {
  // From 2 N on the force stays for 0.9 mm.
  ServoBed bed([](double z_mm) {
    const double depth = std::max(0.0, z_mm - 12.0);
    return 20.0 * std::min(depth, 0.1) + 20.0 * std::max(0.0, depth - 1.0);
  });
  check_steps(bed.steps(1.5, Branch::kLoading), {12.044595018, 12.067260679, 12.074622918});
  check_steps(bed.steps(4.0, Branch::kLoading), {12.167054241, 12.443700402, 12.996992722, 14.0});
  REQUIRE(bed.last.broken);
  CHECK(bed.last.broken->target_n == 4.0);
  CHECK(bed.last.broken->force_n == Approx(22.0));
  CHECK(bed.last.broken->overshoot_n == Approx(18.0));
  CHECK(bed.servo.stiffness_n_per_mm() == Approx(19.94003477798882));

  PressOptions deep = ideal_options();
  deep.max_z_mm = 18.0;
  deep.play_mm = 0.002;
  ServoBed soft(spring(8.0), deep);
  check_steps(soft.steps(5.0, Branch::kLoading),
              {12.066892528, 12.136898664, 12.297231268, 12.508085167, 12.607190729, 12.624532551});
  check_steps(soft.steps(20.0, Branch::kLoading), {13.443084914, 14.22516418, 14.486238133});
  check_steps(soft.steps(18.0, Branch::kUnloading), {14.435615676, 14.283748305, 14.251088655});
}

TEST_CASE("force servo: stops at the maximum depth beyond the contact, with a fault") {
  PressOptions shallow = ideal_options();
  shallow.max_press_mm = 0.3;
  ServoBed bed([](double z_mm) { return 20.0 * std::clamp(z_mm - 12.0, 0.0, 0.2); }, shallow);
  (void)bed.steps(2.0, Branch::kLoading);
  bed.stage.sent_mm.clear();
  check_press_fault([&] { (void)bed.servo.to(10.0, Branch::kLoading, 0.1); }, "TB-PRESS-NO-FORCE",
                    {"10.00 N", "4.00 N", "12.300 mm"});
  check_steps(bed.stage.sent_mm, {12.230729618, 12.3});

  // Unloading ends where the contact is left by the clear way: a force that stays does not go with z.
  ServoBed stuck([](double z_mm) { return z_mm > 12.05 ? 3.0 : 20.0 * std::max(0.0, z_mm - 12.0); });
  stuck.force.law = [](double) { return 3.0; };
  check_press_fault([&] { (void)stuck.servo.to(1.0, Branch::kUnloading, 0.05); }, "TB-PRESS-NO-FORCE", {"11.000 mm"});
  CHECK(stuck.stage.z_mm() == Approx(11.0).margin(1e-9));
}

TEST_CASE("force servo: exact limits of the number of moves and of the time per level") {
  PressOptions few = ideal_options();
  few.max_moves = 4;
  ServoBed enough(spring(20.0), few);
  CHECK(enough.steps(2.0, Branch::kLoading).size() == 4);
  few.max_moves = 3;
  ServoBed lacking(spring(20.0), few);
  lacking.stage.sent_mm.clear();
  check_press_fault([&] { (void)lacking.servo.to(2.0, Branch::kLoading, 0.05); }, "TB-PRESS-TIMEOUT",
                    {"2.00 N", "3 moves"});
  CHECK(lacking.stage.sent_mm.size() == 3);

  // The first move ends after its way and the settling; a level may take exactly so long for a second.
  ServoBed timed(spring(20.0));
  const devices::Nanoseconds begun = timed.clock.now();
  (void)timed.steps(2.0, Branch::kLoading);
  const double took_s = devices::in_seconds(timed.clock.now() - begun);
  const double last_s = (12.099906422 - 12.096679031) / 0.05 + 0.05;
  PressOptions slow = ideal_options();
  slow.level_timeout_s = took_s - last_s + 1e-6;
  ServoBed just(spring(20.0), slow);
  CHECK(just.steps(2.0, Branch::kLoading).size() == 4);
  slow.level_timeout_s = took_s - last_s - 1e-6;
  ServoBed late(spring(20.0), slow);
  CHECK(fault_id_of([&] { (void)late.servo.to(2.0, Branch::kLoading, 0.05); }) == "TB-PRESS-TIMEOUT");
}

TEST_CASE("force servo: a level that is reached needs no move, one passed by more than its tolerance is broken") {
  ServoBed bed(spring(20.0));
  (void)bed.steps(10.0, Branch::kLoading);
  const double there_n = bed.last.reading.force_n;
  bed.stage.sent_mm.clear();
  const double near_n = there_n + 0.05;
  CHECK(bed.servo.to(near_n, Branch::kLoading, near_n - there_n).moves == 0);
  CHECK_FALSE(bed.servo.to(there_n - 0.09, Branch::kLoading, 0.0).broken);
  const ServoResult passed = bed.servo.to(there_n - 0.11, Branch::kLoading, 0.0);
  REQUIRE(passed.broken);
  CHECK(passed.broken->overshoot_n == Approx(0.11));
  CHECK_FALSE(bed.servo.to(there_n + 0.09, Branch::kUnloading, 0.0).broken);
  CHECK(bed.servo.to(there_n + 0.12, Branch::kUnloading, 0.0).broken);
  CHECK(bed.stage.sent_mm.empty());
}

TEST_CASE("force servo: the first step to a level is not limited by earlier steps") {
  PressOptions long_way = ideal_options();
  long_way.max_z_mm = 30.0;
  long_way.max_press_mm = 15.0;
  ServoBed bed(spring(3.0), long_way);
  (void)bed.steps(12.0, Branch::kLoading);
  const double from_mm = bed.last.reading.z_mm;
  const std::vector<double> made = bed.steps(30.0, Branch::kLoading);  // 6 mm further
  CHECK(made.front() - from_mm > 3.5);
  CHECK(bed.last.reading.force_n == Approx(30.0).margin(0.3));
}

TEST_CASE("press options: the tolerance of a level is the larger of its absolute and relative value") {
  const PressOptions options;
  CHECK(options.tolerance(2.0) == 0.05);
  CHECK(options.tolerance(5.0) == 0.05);
  CHECK(options.tolerance(30.0) == Approx(0.3));
  CHECK(options.tolerance(-30.0) == Approx(0.3));
}

// The z axis on an ideal stage: when it polls, what halts it, and what a reading contains.

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
