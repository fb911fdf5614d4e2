// The servo's steps to the last digit, worked out apart from the program by the rules that force_servo.h states, on
// contacts whose law is known: each rule decides in one of them.
#include "bench/run/press/force_servo.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Branch;
using bench::PressOptions;
using bench::ServoResult;
using devices::fault_id_of;

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
