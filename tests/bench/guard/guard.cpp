#include "bench/guard/guard.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "bench/common/error_table.h"
#include "bench/common/process_time.h"
#include "devices/fault.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::bench;
using devices::Axis;
using devices::Psi;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Act>
std::string id_of(Act&& act) {
  const auto fault = devices::fault_of(act);
  if (fault) CHECK(error_row(fault->id())->exit_code == ExitCode::kStopped);
  return fault ? fault->id() : "";
}

double above(double value) { return std::nextafter(value, kInfinity); }
double below(double value) { return std::nextafter(value, -kInfinity); }

struct GuardedBench {
  explicit GuardedBench(double step_psi = 100.0) : guard(limits_with(step_psi), clock) {
    guard.set_log([this](devices::Nanoseconds, const std::string& actuator, const std::string& text, bool through) {
      lines.push_back((through ? "+" : "-") + actuator + ": " + text);
    });
    guard.arm();
    guard.source_armed();
    witness();
  }
  static GuardLimits limits_with(double step_psi) {
    GuardLimits limits;
    limits.safety.step_psi = step_psi;
    limits.axes.fill({0.0, 50.0, 8.0});
    limits.has_force = true;
    return limits;
  }
  void wait(double s) { clock.wait_until(clock.now() + seconds(s)); }
  void witness(double psi = 0.0) {
    guard.note_feedback(Psi(psi), clock.now());
    guard.note_reference(Psi(psi), clock.now());
  }
  void feel(double fx, double fy, double fz) {
    devices::Wrench wrench;
    wrench.force_n = {fx, fy, fz};
    guard.note_force(wrench, clock.now());
  }
  std::string pressure(double psi) {
    const std::string id = id_of([&] { guard.check_pressure(Psi(psi)); });
    if (id.empty()) guard.set_pressure(Psi(psi));
    return id;
  }
  // z then stands at `z_mm`.
  std::string move(Axis axis, double target, double speed = 1.0, double z_mm = 10.0) {
    z.position = devices::Millimetres(z_mm);
    return id_of([&] { guard.check_move(axis, target, speed, [&](Axis) { return z; }); });
  }
  std::string clear(double z_mm) {
    z.position = devices::Millimetres(z_mm);
    const std::string homing = id_of([&] { guard.check_home(Axis::kX, [&](Axis) { return z; }); });
    CHECK(move(Axis::kY, 1.0, 1.0, z_mm) == homing);
    return homing;
  }
  devices::AxisState z{{}, 0, devices::Activity::kIdle, true, {}};
  devices::TurnedClock clock;
  Guard guard;
  std::vector<std::string> lines;
};

}  // namespace

TEST_CASE("guard: the command limit holds at, below and above, and not-a-number is out of range") {
  const auto [psi, id] = GENERATE(table<double, std::string>({{60.0, ""},
                                                              {below(60.0), ""},
                                                              {above(60.0), "TB-CHAMBER-LIMIT"},
                                                              {0.0, ""},
                                                              {below(0.0), "TB-CHAMBER-LIMIT"},
                                                              {kNan, "TB-CHAMBER-LIMIT"},
                                                              {kInfinity, "TB-CHAMBER-LIMIT"}}));
  GuardedBench bench;
  CHECK(bench.pressure(psi) == id);
  if (!id.empty()) CHECK_THAT(bench.lines.at(0), Catch::StartsWith("-pressure"));
}

TEST_CASE("guard: the set-point may rise by one step at once and by the rate limit over time") {
  GuardedBench bench(2.5);
  CHECK(bench.pressure(2.5 + 1e-6) == "TB-CHAMBER-RATE");
  CHECK(bench.pressure(2.5) == "");
  CHECK(bench.pressure(2.5 + 1e-6) == "TB-CHAMBER-RATE");  // nothing left
  bench.wait(0.1);
  CHECK(bench.pressure(4.5 + 1e-6) == "TB-CHAMBER-RATE");  // 20 psi/s for 0.1 s
  CHECK(bench.pressure(4.5) == "");
  for (int i = 1; i <= 20; ++i) {  // a ramp at the largest rate, some ticks late and some early
    bench.wait(i % 2 == 0 ? 0.08 : 0.12);
    bench.witness();
    CHECK(bench.pressure(4.5 + 2.0 * i) == "");
  }
  CHECK(bench.pressure(1.0) == "");  // down at once
  CHECK(bench.pressure(40.0) == "TB-CHAMBER-RATE");
}

TEST_CASE("guard: the pressure may rise only with fresh readings of the witnesses, and may always fall") {
  GuardedBench bench;
  CHECK(bench.pressure(30.0) == "");
  bench.wait(1.0);
  CHECK(bench.pressure(31.0) == "");
  bench.clock.wait_until(bench.clock.now() + devices::Nanoseconds(1));
  CHECK(bench.pressure(32.0) == "TB-CHAMBER-STALE");
  CHECK(bench.pressure(20.0) == "");
  bench.guard.note_feedback(Psi(20.0), bench.clock.now());
  CHECK(bench.pressure(21.0) == "TB-CHAMBER-STALE");  // the reference is still old
  bench.guard.note_reference(Psi(20.0), bench.clock.now());
  CHECK(bench.pressure(21.0) == "");

  Guard unread(GuardedBench::limits_with(100.0), bench.clock);
  unread.arm();
  CHECK(id_of([&] { unread.check_pressure(Psi(1.0)); }) == "TB-CHAMBER-STALE");
}

TEST_CASE("guard: silent until armed") {
  const devices::TurnedClock clock;
  Guard guard(GuardedBench::limits_with(100.0), clock);
  CHECK(id_of([&] { guard.check_pressure(Psi(0.0)); }) == "TB-GUARD-NOT-ARMED");
  CHECK(id_of([&] { guard.check_move(Axis::kX, 1.0, 1.0, [](Axis) { return devices::AxisState{}; }); }) ==
        "TB-GUARD-NOT-ARMED");
  CHECK(id_of([&] { guard.check_home(Axis::kZ, [](Axis) { return devices::AxisState{}; }); }) == "TB-GUARD-NOT-ARMED");
  guard.note_feedback(Psi(100.0), clock.now());  // nothing that it could do about it
  guard.note_reference(Psi(100.0), clock.now());
  CHECK_FALSE(guard.tripped());
}

TEST_CASE("guard: measured pressure beyond the limit trips, and the trip latches until a person resets it") {
  const auto [psi, trips] = GENERATE(
      table<double, bool>({{66.0, false}, {below(66.0), false}, {above(66.0), true}, {kNan, true}, {-1.0, false}}));
  const bool by_reference = GENERATE(false, true);
  GuardedBench bench;
  const std::string id = id_of([&] {
    if (by_reference) {
      bench.guard.note_reference(Psi(psi), bench.clock.now());
    } else {
      bench.guard.note_feedback(Psi(psi), bench.clock.now());
    }
  });
  CHECK(id == (trips ? "TB-CHAMBER-TRIP" : ""));
  CHECK(bench.guard.tripped().has_value() == trips);
  if (!trips) return;
  bench.witness();  // quiet again, and noted without a further fault
  CHECK(bench.pressure(0.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kX, 1.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kZ, 11.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kZ, 9.0) == "");  // away from the specimen
  CHECK_NOTHROW(bench.guard.check_rewriting());
  bench.guard.trip("TB-OTHER", "a second cause");
  CHECK(bench.guard.tripped()->id == "TB-CHAMBER-TRIP");
  bench.guard.reset("somebody");
  CHECK(bench.pressure(1.0) == "");
  CHECK_THAT(bench.lines.back(), Catch::Contains("+pressure"));
}

TEST_CASE("guard: force beyond its axis' limit trips") {
  const std::size_t axis = GENERATE(0, 1, 2);
  const double sign = GENERATE(1.0, -1.0);
  const double limit = axis == 2 ? 35.0 : 5.0;
  const auto felt = [&](double newtons) {
    GuardedBench bench;
    std::array<double, 3> force{};
    force[axis] = sign * newtons;
    return id_of([&] { bench.feel(force[0], force[1], force[2]); });
  };
  CHECK(felt(limit) == "");
  CHECK(felt(below(limit)) == "");
  CHECK(felt(above(limit)) == "TB-FORCE-TRIP");
  CHECK(felt(kNan) == "TB-FORCE-TRIP");
}

TEST_CASE("guard: position and speed have limits of their own") {
  GuardedBench bench;
  bench.feel(0.0, 0.0, 0.0);
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) {
    CHECK(bench.move(axis, 0.0) == "");
    CHECK(bench.move(axis, below(0.0)) == "TB-STAGE-LIMIT");
    CHECK(bench.move(axis, 50.0) == "");
    CHECK(bench.move(axis, above(50.0)) == "TB-STAGE-LIMIT");
    CHECK(bench.move(axis, kNan) == "TB-STAGE-LIMIT");
    CHECK(bench.move(axis, 1.0, 8.0) == "");
    CHECK(bench.move(axis, 1.0, above(8.0)) == "TB-STAGE-LIMIT");
    CHECK(bench.move(axis, 1.0, 0.0) == "TB-STAGE-LIMIT");
    CHECK(bench.move(axis, 1.0, kNan) == "TB-STAGE-LIMIT");
  }
}

TEST_CASE("guard: x and y move only while z is homed, at rest and clear, and no force is measured") {
  GuardedBench bench;
  CHECK(bench.clear(25.0) == "");
  CHECK(bench.clear(above(25.0)) == "TB-STAGE-ENVELOPE");
  CHECK(bench.clear(kNan) == "TB-STAGE-ENVELOPE");
  bench.z.homed = false;
  CHECK(bench.clear(1.0) == "TB-STAGE-ENVELOPE");
  bench.z.homed = true;
  bench.z.activity = devices::Activity::kMoving;
  CHECK(bench.clear(1.0) == "TB-STAGE-ENVELOPE");
  bench.z.activity = devices::Activity::kIdle;
  bench.guard.set_moving(Axis::kZ, true);
  CHECK(bench.clear(1.0) == "TB-STAGE-ENVELOPE");
  bench.guard.set_moving(Axis::kZ, false);
  bench.feel(0.0, 0.0, -0.5);
  CHECK(bench.clear(1.0) == "TB-STAGE-ENVELOPE");
  bench.feel(0.0, 0.3, 0.39);
  CHECK(bench.clear(1.0) == "");
  bench.feel(0.0, 0.3, 0.41);  // 0.508 N in all
  CHECK(bench.clear(1.0) == "TB-STAGE-ENVELOPE");
}

TEST_CASE("guard: z goes where it may touch only under a fresh force reading and with x and y at rest") {
  GuardedBench bench;
  CHECK(bench.move(Axis::kZ, 25.0) == "");
  CHECK(bench.move(Axis::kZ, above(25.0)) == "TB-FORCE-STALE");  // never read
  bench.feel(0.0, 0.0, 0.0);
  CHECK(bench.move(Axis::kZ, 30.0) == "");
  bench.wait(1.0);
  CHECK(bench.move(Axis::kZ, 30.0) == "");
  bench.wait(0.001);
  CHECK(bench.move(Axis::kZ, 30.0) == "TB-FORCE-STALE");
  CHECK(bench.move(Axis::kZ, 30.0, 1.0, 31.0) == "");  // away
  bench.feel(0.0, 0.0, 0.0);
  bench.guard.set_moving(Axis::kY, true);
  CHECK(bench.move(Axis::kZ, 30.0) == "TB-STAGE-ENVELOPE");
  bench.guard.set_moving(Axis::kY, false);
  CHECK(bench.move(Axis::kZ, 30.0) == "");
}

TEST_CASE("dead-man: fires when fed later than its time, and stays so") {
  DeadMan dead_man(seconds(0.4));
  CHECK_FALSE(dead_man.late(seconds(100.0)));  // never fed: not yet begun
  dead_man.feed(seconds(100.0));
  CHECK_FALSE(dead_man.late(seconds(100.4)));
  dead_man.feed(seconds(100.4));
  CHECK(dead_man.left(seconds(100.5)) == seconds(0.3));
  CHECK(dead_man.late(seconds(100.4) + seconds(0.4) + devices::Nanoseconds(1)));
  dead_man.feed(seconds(100.9));
  CHECK(dead_man.late(seconds(100.9)));
}

TEST_CASE("dead-man: it fires when fed too late, also without a query in between") {
  DeadMan dead_man(seconds(0.4));
  dead_man.feed(seconds(1.0));
  dead_man.feed(seconds(2.0));
  CHECK(dead_man.late(seconds(2.0)));
}

TEST_CASE("guard: after a dead-man has fired no command passes, even after a reset") {
  GuardedBench bench;
  ProcessTimeWatcher watcher(seconds(1.9), bench.clock);
  bench.guard.set_watcher(&watcher);
  bench.guard.feed();
  CHECK(bench.pressure(10.0) == "");
  bench.wait(1.9);
  bench.guard.feed();
  bench.wait(2.0);
  bench.witness();
  CHECK(bench.pressure(9.0) == "TB-DEADMAN-FIRED");
  CHECK(id_of([&] { bench.guard.check_rewriting(); }) == "TB-DEADMAN-FIRED");
  CHECK(bench.move(Axis::kZ, 1.0, 1.0, 5.0) == "TB-DEADMAN-FIRED");
  bench.guard.reset("somebody");
  bench.guard.feed();
  CHECK(bench.pressure(9.0) == "TB-DEADMAN-FIRED");
}

TEST_CASE("guard: logs refusals and stage commands, and set-points as they change by a level") {
  GuardedBench bench;
  for (const double psi : {0.5, 1.0, 1.5, 2.0, 0.0}) CHECK(bench.pressure(psi) == "");
  CHECK(bench.pressure(61.0) == "TB-CHAMBER-LIMIT");
  CHECK(bench.move(Axis::kX, 3.0) == "");
  CHECK(bench.lines == std::vector<std::string>{"+pressure: 1 psi", "+pressure: 2 psi", "+pressure: 0 psi",
                                                "-pressure: 61 psi: allowed is 0 to 60 psi",
                                                "+stage x: a move to 3 mm at 1 mm/s"});
}
