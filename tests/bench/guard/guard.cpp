#include "bench/guard/guard.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/error_table.h"
#include "bench/common/process_time.h"
#include "devices/device.h"
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
  devices::ManualClock clock;
  Guard guard;
  std::vector<std::string> lines;
};

}  // namespace

TEST_CASE("guard: accepts pressures from 0 to the command limit, and rejects values that are not finite") {
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

TEST_CASE("guard: the pressure may rise only with fresh feedback and reference, and may always fall") {
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

TEST_CASE("guard: rejects every command and does not trip before it is armed") {
  const devices::ManualClock clock;
  Guard guard(GuardedBench::limits_with(100.0), clock);
  CHECK(id_of([&] { guard.check_pressure(Psi(0.0)); }) == "TB-GUARD-NOT-ARMED");
  CHECK(id_of([&] { guard.check_move(Axis::kX, 1.0, 1.0, [](Axis) { return devices::AxisState{}; }); }) ==
        "TB-GUARD-NOT-ARMED");
  CHECK(id_of([&] { guard.check_home(Axis::kZ, [](Axis) { return devices::AxisState{}; }); }) == "TB-GUARD-NOT-ARMED");
  guard.note_feedback(Psi(100.0), clock.now());  // nothing that it could do about it
  guard.note_reference(Psi(100.0), clock.now());
  CHECK_FALSE(guard.tripped());
}

TEST_CASE("guard: measured pressure above the limit trips, and the trip latches until an operator resets it") {
  const auto [psi, trips] = GENERATE(table<double, bool>(
      {{66.0, false}, {below(66.0), false}, {above(66.0), true}, {66.25, true}, {kNan, true}, {-1.0, false}}));
  const bool by_reference = GENERATE(false, true);
  GuardedBench bench;
  const auto fault = devices::fault_of([&] {
    if (by_reference) {
      bench.guard.note_reference(Psi(psi), bench.clock.now());
    } else {
      bench.guard.note_feedback(Psi(psi), bench.clock.now());
    }
  });
  REQUIRE(fault.has_value() == trips);
  CHECK(bench.guard.tripped().has_value() == trips);
  if (!trips) return;
  CHECK(fault->id() == "TB-CHAMBER-TRIP");
  CHECK(fault->device() == "chamber");
  CHECK_THAT(fault->what(), Catch::Contains("66.0 psi"));
  if (psi == 66.25) CHECK_THAT(fault->what(), Catch::Contains("66.2 psi"));
  CHECK((std::string(fault->what()).find("reference") != std::string::npos) == by_reference);
  const Error shown = as_error(std::make_exception_ptr(*fault));
  CHECK(shown.code() == ExitCode::kStopped);
  CHECK_THAT(shown.remedy(), Catch::Contains("trip_psi"));
  bench.witness();  // quiet again, and noted without a further fault
  CHECK(bench.pressure(0.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kX, 1.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kZ, 11.0) == "TB-GUARD-TRIPPED");
  CHECK(bench.move(Axis::kZ, 9.0) == "");  // away from the specimen
  CHECK(bench.move(Axis::kZ, 10.0) == "");
  CHECK(bench.clear(40.0) == "TB-GUARD-TRIPPED");
  CHECK(id_of([&] { bench.guard.check_home(Axis::kZ, [&](Axis) { return bench.z; }); }) == "");
  CHECK_NOTHROW(bench.guard.check_rewriting());  // of 0 psi
  bench.guard.trip("TB-OTHER", "a second cause");
  CHECK(bench.guard.tripped()->id == "TB-CHAMBER-TRIP");
  bench.guard.reset("somebody");
  CHECK(bench.pressure(1.0) == "");
  CHECK_THAT(bench.lines.back(), Catch::Contains("+pressure"));
}

TEST_CASE("guard: force above the limit of its axis trips") {
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

TEST_CASE("guard: each axis has limits of position and speed") {
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

TEST_CASE("guard: x and y move only if z is homed, at rest and clear, and no force is measured") {
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

TEST_CASE("guard: z moves into possible contact only with a fresh force reading, and with x and y at rest") {
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

TEST_CASE("dead-man: fires if fed later than its timeout, and stays fired") {
  DeadMan dead_man(seconds(0.4));
  CHECK_FALSE(dead_man.late(seconds(100.0)));  // never fed: not yet begun
  dead_man.feed(seconds(100.0));
  CHECK_FALSE(dead_man.late(seconds(100.4)));
  dead_man.feed(seconds(100.4));
  CHECK(dead_man.left(seconds(100.5)) == seconds(0.3));
  CHECK(dead_man.late(seconds(100.4) + seconds(0.4) + devices::Nanoseconds(1)));
  dead_man.feed(seconds(100.9));
  CHECK(dead_man.late(seconds(100.9)));
  DeadMan unasked(seconds(0.4));
  unasked.feed(seconds(1.0));
  unasked.feed(seconds(2.0));
  CHECK(unasked.late(seconds(2.0)));
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

TEST_CASE("guard: logs refusals, stage commands, and set-points when they change by a level") {
  GuardedBench bench;
  for (const double psi : {0.5, 1.0, 1.5, 2.0, 0.0}) CHECK(bench.pressure(psi) == "");
  CHECK(bench.pressure(61.0) == "TB-CHAMBER-LIMIT");
  CHECK(bench.move(Axis::kX, 3.0) == "");
  const std::vector<std::string> heads = {"+pressure: 1 psi", "+pressure: 2 psi", "+pressure: 0 psi",
                                          "-pressure: 61 psi", "+stage x: "};
  REQUIRE(bench.lines.size() == heads.size());
  for (std::size_t i = 0; i < heads.size(); ++i) CHECK_THAT(bench.lines[i], Catch::StartsWith(heads[i]));
  CHECK_THAT(bench.lines.back(), Catch::Contains("3 mm") && Catch::Contains("1 mm/s"));
}

TEST_CASE("guard: a refusal states the requested value and the limits, and is logged") {
  GuardedBench bench(2.5);
  bench.feel(0.0, 0.0, 0.0);
  const auto refused = [&](const std::string& id, const std::string& device, const std::vector<std::string>& numbers,
                           const std::function<void()>& act) {
    bench.lines.clear();
    const auto fault = devices::fault_of(act);
    REQUIRE(fault);
    INFO(fault->what());
    CHECK(fault->id() == id);
    CHECK(fault->device() == device);
    CHECK_FALSE(as_error(std::make_exception_ptr(*fault)).remedy().empty());
    REQUIRE(bench.lines.size() == 1);
    CHECK_THAT(bench.lines[0], Catch::StartsWith("-" + device + ": "));
    for (const std::string& number : numbers) {
      INFO(number);
      CHECK(std::string(fault->what()).find(number) != std::string::npos);
      CHECK(bench.lines[0].find(number) != std::string::npos);
    }
  };
  const auto pressure = [&](double psi) { return [&bench, psi] { bench.guard.check_pressure(Psi(psi)); }; };
  const auto move = [&](Axis axis, double mm, double speed, double z_mm) {
    return [&bench, axis, mm, speed, z_mm] {
      bench.z.position = devices::Millimetres(z_mm);
      bench.guard.check_move(axis, mm, speed, [&](Axis) { return bench.z; });
    };
  };
  refused("TB-CHAMBER-LIMIT", "pressure", {"60.5 psi", "60 psi"}, pressure(60.5));
  CHECK(bench.pressure(2.0) == "");
  bench.wait(0.05);  // of the step 0.5 psi are left, and 1 psi has come
  refused("TB-CHAMBER-RATE", "pressure", {"3.75 psi", "2 psi", "1.5 psi", "2.5 psi", "20 psi/s"}, pressure(3.75));
  refused("TB-STAGE-LIMIT", "stage x", {"51 mm", "0 to 50 mm", "8 mm/s"}, move(Axis::kX, 51.0, 1.0, 10.0));
  refused("TB-STAGE-LIMIT", "stage z", {"8.5 mm/s", "8 mm/s"}, move(Axis::kZ, 5.0, 8.5, 10.0));
  refused("TB-STAGE-ENVELOPE", "stage y", {"26.12 mm", "25 mm"}, move(Axis::kY, 5.0, 1.0, 26.125));
  bench.feel(0.3, 0.0, 0.4);
  refused("TB-STAGE-ENVELOPE", "stage y", {"0.50 N", "0.5 N"}, move(Axis::kY, 5.0, 1.0, 10.0));
  bench.wait(1.25);
  refused("TB-CHAMBER-STALE", "pressure", {"1.30 s", "1 s"}, pressure(2.5));
  refused("TB-FORCE-STALE", "stage z", {"1.25 s", "1 s"}, move(Axis::kZ, 30.0, 1.0, 10.0));
  bench.guard.vented(false);
  CHECK(bench.lines.back().starts_with("+pressure: "));
  const auto tripped = devices::fault_of([&] { bench.feel(0.0, -5.5, 0.0); });
  REQUIRE(tripped);
  CHECK(tripped->device() == "force sensor");
  CHECK_THAT(tripped->what(), Catch::Contains("Fy = -5.50 N") && Catch::Contains("5 N"));
  refused("TB-GUARD-TRIPPED", "stage x", {"TB-FORCE-TRIP", "-5.50 N"}, move(Axis::kX, 5.0, 1.0, 10.0));
}

TEST_CASE("guard limits: the age limit scales with the clock rate but not below real time, axes come from the bench") {
  BenchConfig config;
  config.limits.stale_s = 0.8;
  config.limits.command_psi = 55.0;
  config.limits.force_n = {4.0, 6.0, 30.0};
  CHECK(guard_limits(config).safety.stale_s == 0.8);
  config.rate = 20.0;
  CHECK(guard_limits(config).safety.stale_s == Approx(16.0));
  config.rate = 0.25;
  CHECK(guard_limits(config).safety.stale_s == 0.8);
  CHECK(guard_limits(config).safety.command_psi == 55.0);
  CHECK(guard_limits(config).safety.force_n == std::array<double, 3>{4.0, 6.0, 30.0});
  CHECK_FALSE(guard_limits(config).has_force);
  CHECK(guard_limits(config).axes[2].high_mm == 0.0);  // no stage, no way
  config.force.emplace();
  config.stage.emplace();
  devices::AxisOptions& z = config.stage->options.axes[2];
  z.low = devices::Millimetres(1.5);
  z.high = devices::Millimetres(42.0);
  z.maximum_speed = devices::MillimetresPerSecond(7.0);
  config.stage->options.axes[0].high = devices::Millimetres(58.0);
  const GuardLimits limits = guard_limits(config);
  CHECK(limits.has_force);
  CHECK((limits.axes[2].low_mm == 1.5 && limits.axes[2].high_mm == 42.0 && limits.axes[2].speed_mm_per_s == 7.0));
  CHECK(limits.axes[0].high_mm == 58.0);
}

TEST_CASE("guard: the allowed pressure step recovers with time up to its maximum, with a tolerance of 1e-9") {
  CHECK(GuardedBench(2.5).pressure(2.5 * (1.0 + 0.9e-9)) == "");
  CHECK(GuardedBench(2.5).pressure(2.5 * (1.0 + 1.1e-9)) == "TB-CHAMBER-RATE");
  GuardedBench bench(2.5);
  CHECK(bench.pressure(1.0) == "");
  CHECK(bench.pressure(2.6) == "TB-CHAMBER-RATE");  // 1.5 psi are left
  CHECK(bench.pressure(0.5) == "");                 // going down gives nothing back
  CHECK(bench.pressure(2.1) == "TB-CHAMBER-RATE");
  CHECK(bench.pressure(2.0) == "");
  bench.clock.wait_until(seconds(0.05));
  CHECK(bench.pressure(3.1) == "TB-CHAMBER-RATE");  // 1 psi in 50 ms
  CHECK(bench.pressure(3.0) == "");
  bench.clock.wait_until(seconds(0.9));
  CHECK(bench.pressure(5.6) == "TB-CHAMBER-RATE");
  CHECK(bench.pressure(5.5) == "");
  for (int i = 1; i <= 20; ++i) {  // a ramp at the largest rate, 20 psi/s, some ticks late and some early
    bench.wait(i % 2 == 0 ? 0.08 : 0.12);
    bench.witness();
    CHECK(bench.pressure(5.5 + 2.0 * i) == "");
  }
  CHECK(bench.pressure(1.0) == "");  // down at once
  CHECK(bench.pressure(40.0) == "TB-CHAMBER-RATE");
}
