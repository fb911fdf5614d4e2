// The guard's words: each refusal and each trip as a person, the log and the stored trip have it.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/guard/guard.h"
#include "devices/fault.h"
#include "tests/bench/run/press/ideal_press.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::bench;
using devices::Axis;
using devices::Psi;

namespace {

// Never fires; lost when it is told so.
class QuietWatcher final : public Watcher {
 public:
  void feed() override {}
  bool fired() override { return false; }
  std::optional<WatcherLost> lost() override { return gone; }
  bool wait_ended(devices::Nanoseconds) override { return false; }
  std::optional<WatcherLost> gone;
};

class TalkingGuard {
 public:
  TalkingGuard() : stage(clock), guard(limits(), clock) {
    guard.set_run(12);
    guard.set_actuators(nullptr, &stage);
    guard.set_watcher(&watcher);
    guard.set_log([this](devices::Nanoseconds time, const std::string& actuator, const std::string& text,
                         bool through) {
      said.push_back(fmt::format("  {:g} s {} {}: {}", devices::in_seconds(time), through ? "+" : "-", actuator, text));
    });
    guard.set_trip_sink([this](const Trip& trip) {
      said.push_back(fmt::format("  stored {} of run {}: {}", trip.id, trip.run, trip.what));
    });
  }
  static GuardLimits limits() {
    GuardLimits limits;
    limits.safety.step_psi = 2.5;
    limits.safety.rate_psi_per_s = 20.0;
    limits.axes.fill({1.0, 50.0, 8.0});
    limits.has_force = true;
    return limits;
  }
  void act(const std::string& what, const std::function<void()>& deed) {
    said.push_back(what);
    const auto fault = devices::fault_of(deed);
    if (fault)
      said.push_back(fmt::format("  {} {}: {} | {}", fault->id(), fault->device(), fault->what(),
                                 as_error(std::make_exception_ptr(*fault)).remedy()));
  }
  void wait(double s) { clock.wait_until(clock.now() + seconds(s)); }
  void see(double psi) {
    guard.note_feedback(Psi(psi), clock.now());
    guard.note_reference(Psi(psi), clock.now());
  }
  void feel(double fx, double fy, double fz) {
    devices::Wrench wrench;
    wrench.force_n = {fx, fy, fz};
    guard.note_force(wrench, clock.now());
  }
  void move(const char* what, Axis axis, double target_mm, double speed = 1.0) {
    act(what, [&] { guard.check_move(axis, target_mm, speed, [&](Axis) { return z; }); });
  }
  devices::AxisState z{devices::Millimetres(10.0), 0, devices::Activity::kIdle, true, {}};
  devices::TurnedClock clock;
  tests::IdealStage stage;
  QuietWatcher watcher;
  Guard guard;
  std::vector<std::string> said;
};

void check_said(const std::vector<std::string>& said, const std::string& expected) {
  std::string all = "\n";
  for (const std::string& line : said) all += line + "\n";
  CHECK(all == expected);
}

}  // namespace

TEST_CASE("guard's words: pressure") {
  TalkingGuard bench;
  Guard& guard = bench.guard;
  bench.act("not armed", [&] { guard.check_pressure(Psi(1.0)); });
  guard.arm();
  guard.source_armed();
  bench.act("never read", [&] { guard.check_pressure(Psi(1.0)); });
  guard.note_feedback(Psi(0.0), bench.clock.now());
  bench.act("reference never read", [&] { guard.check_pressure(Psi(1.0)); });
  bench.see(0.0);
  bench.wait(1.25);
  bench.act("old", [&] { guard.check_pressure(Psi(1.0)); });
  bench.see(0.0);
  bench.act("beyond", [&] { guard.check_pressure(Psi(60.5)); });
  bench.act("too quick", [&] { guard.check_pressure(Psi(5.0)); });
  bench.act("well", [&] { guard.check_pressure(Psi(2.0)); });
  guard.set_pressure(Psi(2.0));
  bench.wait(0.05);
  bench.act("too quick again", [&] { guard.check_pressure(Psi(3.75)); });
  bench.act("again", [&] { guard.check_rewriting(); });
  bench.act("vented", [&] { guard.vented(false); });
  bench.act("vented", [&] { guard.vented(true); });
  bench.act("vented", [&] { guard.vented(true); });
  bench.act("too high", [&] { guard.note_reference(Psi(66.25), bench.clock.now()); });
  bench.act("tripped", [&] { guard.check_pressure(Psi(0.0)); });
  bench.act("reset", [&] { guard.reset("N. N."); });
  bench.act("too high by feedback", [&] { guard.note_feedback(Psi(70.0), bench.clock.now()); });
  check_said(bench.said, R"(
not armed
  0 s - pressure: 1 psi: it is not armed
  TB-GUARD-NOT-ARMED pressure: 1 psi was asked for and refused by the guard: it is not armed; nothing was sent | Arm the pressure source or the stage first.
never read
  0 s - pressure: 1 psi: the regulator's feedback has not been read
  TB-CHAMBER-STALE pressure: 1 psi was asked for and refused by the guard: the regulator's feedback has not been read; nothing was sent | Read the instrument before loading; [limits] stale_s.
reference never read
  0 s - pressure: 1 psi: the reference has not been read
  TB-CHAMBER-STALE pressure: 1 psi was asked for and refused by the guard: the reference has not been read; nothing was sent | Read the instrument before loading; [limits] stale_s.
old
  1.25 s - pressure: 1 psi: the last reading of the regulator's feedback is 1.25 s old, 1 s are allowed
  TB-CHAMBER-STALE pressure: 1 psi was asked for and refused by the guard: the last reading of the regulator's feedback is 1.25 s old, 1 s are allowed; nothing was sent | Read the instrument before loading; [limits] stale_s.
beyond
  1.25 s - pressure: 60.5 psi: allowed is 0 to 60 psi
  TB-CHAMBER-LIMIT pressure: 60.5 psi was asked for and refused by the guard: allowed is 0 to 60 psi; nothing was sent | Correct the recipe; [limits] command_psi is the chamber's limit.
too quick
  1.25 s - pressure: 5 psi: the set-point is 0 psi and may rise by 2.5 psi now (2.5 psi at once, 20 psi/s continuously)
  TB-CHAMBER-RATE pressure: 5 psi was asked for and refused by the guard: the set-point is 0 psi and may rise by 2.5 psi now (2.5 psi at once, 20 psi/s continuously); nothing was sent | Approach the level by a ramp; [limits] step_psi and rate_psi_per_s.
well
  1.25 s + pressure: 2 psi
too quick again
  1.3 s - pressure: 3.75 psi: the set-point is 2 psi and may rise by 1.5 psi now (2.5 psi at once, 20 psi/s continuously)
  TB-CHAMBER-RATE pressure: 3.75 psi was asked for and refused by the guard: the set-point is 2 psi and may rise by 1.5 psi now (2.5 psi at once, 20 psi/s continuously); nothing was sent | Approach the level by a ramp; [limits] step_psi and rate_psi_per_s.
again
vented
  1.3 s + pressure: vent, not read back
vented
vented
too high
  1.3 s - guard: trip TB-CHAMBER-TRIP: 66.2 psi measured by the reference, above the trip of 66.0 psi
  stored TB-CHAMBER-TRIP of run 12: 66.2 psi measured by the reference, above the trip of 66.0 psi
  TB-CHAMBER-TRIP chamber: 66.2 psi measured by the reference, above the trip of 66.0 psi; vented | check regulator and reference before the next run; the limit is [limits] trip_psi
tripped
  1.3 s - pressure: 0 psi: tripped (TB-CHAMBER-TRIP): 66.2 psi measured by the reference, above the trip of 66.0 psi
  TB-GUARD-TRIPPED pressure: 0 psi was asked for and refused by the guard: tripped (TB-CHAMBER-TRIP): 66.2 psi measured by the reference, above the trip of 66.0 psi; nothing was sent | Inspect the rig and find the cause, then `tactbench devices reset`.
reset
  1.3 s + guard: reset by N. N.
too high by feedback
  1.3 s - guard: trip TB-CHAMBER-TRIP: 70.0 psi measured by the regulator's feedback, above the trip of 66.0 psi
  stored TB-CHAMBER-TRIP of run 12: 70.0 psi measured by the regulator's feedback, above the trip of 66.0 psi
  TB-CHAMBER-TRIP chamber: 70.0 psi measured by the regulator's feedback, above the trip of 66.0 psi; vented | check regulator and reference before the next run; the limit is [limits] trip_psi
)");
}

TEST_CASE("guard's words: stage and force") {
  TalkingGuard bench;
  Guard& guard = bench.guard;
  bench.move("not armed", Axis::kY, 5.0);
  guard.stage_armed();
  bench.move("beyond", Axis::kX, 51.0);
  bench.move("too fast", Axis::kZ, 5.0, 8.5);
  bench.move("well", Axis::kX, 5.0);
  bench.move("no force known", Axis::kZ, 30.0);
  bench.feel(0.0, 0.0, 0.0);
  bench.wait(1.5);
  bench.move("force is old", Axis::kZ, 30.0);
  guard.set_moving(Axis::kX, true);
  bench.move("x moves", Axis::kZ, 30.0);
  guard.set_moving(Axis::kX, false);
  guard.set_moving(Axis::kZ, true);
  bench.move("z moves", Axis::kX, 5.0);
  guard.set_moving(Axis::kZ, false);
  bench.z.homed = false;
  bench.act("z not homed", [&] { guard.check_home(Axis::kY, [&](Axis) { return bench.z; }); });
  bench.act("z is homed", [&] { guard.check_home(Axis::kZ, [&](Axis) { return bench.z; }); });
  bench.z.homed = true;
  bench.z.position = devices::Millimetres(26.125);
  bench.move("z deep", Axis::kY, 5.0);
  bench.z.position = devices::Millimetres(10.0);
  bench.feel(0.3, 0.0, 0.4);
  bench.move("in contact", Axis::kY, 5.0);
  bench.act("force", [&] { bench.feel(0.0, -5.5, 0.0); });
  CHECK(bench.stage.halts == 1);
  bench.move("tripped", Axis::kX, 5.0);
  bench.move("away", Axis::kZ, 9.0);
  check_said(bench.said, R"(
not armed
  0 s - stage y: a move to 5 mm at 1 mm/s: it is not armed
  TB-GUARD-NOT-ARMED stage y: a move to 5 mm at 1 mm/s was asked for and refused by the guard: it is not armed; nothing was sent | Arm the pressure source or the stage first.
beyond
  0 s - stage x: a move to 51 mm at 1 mm/s: allowed is 1 to 50 mm at up to 8 mm/s
  TB-STAGE-LIMIT stage x: a move to 51 mm at 1 mm/s was asked for and refused by the guard: allowed is 1 to 50 mm at up to 8 mm/s; nothing was sent | Correct the recipe; the limits in the bench file are those of the rig.
too fast
  0 s - stage z: a move to 5 mm at 8.5 mm/s: allowed is 1 to 50 mm at up to 8 mm/s
  TB-STAGE-LIMIT stage z: a move to 5 mm at 8.5 mm/s was asked for and refused by the guard: allowed is 1 to 50 mm at up to 8 mm/s; nothing was sent | Correct the recipe; the limits in the bench file are those of the rig.
well
  0 s + stage x: a move to 5 mm at 1 mm/s
no force known
  0 s - stage z: a move to 30 mm at 1 mm/s: the force sensor, tared, has not been read
  TB-FORCE-STALE stage z: a move to 30 mm at 1 mm/s was asked for and refused by the guard: the force sensor, tared, has not been read; nothing was sent | Read the instrument before loading; [limits] stale_s.
force is old
  1.5 s - stage z: a move to 30 mm at 1 mm/s: the last reading of the force sensor, tared, is 1.50 s old, 1 s are allowed
  TB-FORCE-STALE stage z: a move to 30 mm at 1 mm/s was asked for and refused by the guard: the last reading of the force sensor, tared, is 1.50 s old, 1 s are allowed; nothing was sent | Read the instrument before loading; [limits] stale_s.
x moves
  1.5 s - stage z: a move to 30 mm at 1 mm/s: x or y moves, and beyond 25 mm they must be at rest
  TB-STAGE-ENVELOPE stage z: a move to 30 mm at 1 mm/s was asked for and refused by the guard: x or y moves, and beyond 25 mm they must be at rest; nothing was sent | Wait for the end of the move first; [limits] clear_z_mm.
z moves
  1.5 s - stage x: a move to 5 mm at 1 mm/s: z moves
  TB-STAGE-ENVELOPE stage x: a move to 5 mm at 1 mm/s was asked for and refused by the guard: z moves; nothing was sent | Wait until z is at rest.
z not homed
  1.5 s - stage y: homing: z was not homed, so it may be in contact
  TB-STAGE-ENVELOPE stage y: homing was asked for and refused by the guard: z was not homed, so it may be in contact; nothing was sent | Home z before x and y.
z is homed
  1.5 s + stage z: homing
z deep
  1.5 s - stage y: a move to 5 mm at 1 mm/s: z is at 26.12 mm, beyond 25 mm
  TB-STAGE-ENVELOPE stage y: a move to 5 mm at 1 mm/s was asked for and refused by the guard: z is at 26.12 mm, beyond 25 mm; nothing was sent | Retract z first; [limits] clear_z_mm.
in contact
  1.5 s - stage y: a move to 5 mm at 1 mm/s: the last force reading was 0.50 N, in contact from 0.5 N
  TB-STAGE-ENVELOPE stage y: a move to 5 mm at 1 mm/s was asked for and refused by the guard: the last force reading was 0.50 N, in contact from 0.5 N; nothing was sent | Retract z and read the force again; [limits] contact_n.
force
  1.5 s - guard: trip TB-FORCE-TRIP: Fy = -5.50 N measured, beyond the limit of 5 N
  stored TB-FORCE-TRIP of run 12: Fy = -5.50 N measured, beyond the limit of 5 N
  TB-FORCE-TRIP force sensor: Fy = -5.50 N measured, beyond the limit of 5 N; stage halted | check what the indenter presses on; the limit is [limits] force_n
tripped
  1.5 s - stage x: a move to 5 mm at 1 mm/s: tripped (TB-FORCE-TRIP): Fy = -5.50 N measured, beyond the limit of 5 N
  TB-GUARD-TRIPPED stage x: a move to 5 mm at 1 mm/s was asked for and refused by the guard: tripped (TB-FORCE-TRIP): Fy = -5.50 N measured, beyond the limit of 5 N; nothing was sent | Inspect the rig and find the cause, then `tactbench devices reset`.
away
  1.5 s + stage z: a move to 9 mm at 1 mm/s
)");
}

TEST_CASE("guard's words: a dead-man that is lost") {
  TalkingGuard bench;
  bench.guard.stage_armed();
  bench.feel(0.0, 0.0, 0.0);
  bench.watcher.gone = WatcherLost{"TB-DEADMAN-BLIND", "it sees nothing", "Give it eyes."};
  bench.move("blind", Axis::kZ, 30.0);
  bench.move("blind still", Axis::kX, 5.0);
  bench.move("away", Axis::kZ, 9.0);
  bench.act("reset", [&] { bench.guard.reset("N. N."); });
  CHECK(bench.stage.halts == 1);
  check_said(bench.said, R"(
blind
  0 s - guard: trip TB-DEADMAN-BLIND: it sees nothing
  stored TB-DEADMAN-BLIND of run 12: it sees nothing
  0 s - stage z: a move to 30 mm at 1 mm/s: it sees nothing
  TB-DEADMAN-BLIND stage z: a move to 30 mm at 1 mm/s was asked for and refused by the guard: it sees nothing; nothing was sent | Give it eyes.
blind still
  0 s - stage x: a move to 5 mm at 1 mm/s: it sees nothing
  TB-DEADMAN-BLIND stage x: a move to 5 mm at 1 mm/s was asked for and refused by the guard: it sees nothing; nothing was sent | Give it eyes.
away
  0 s + stage z: a move to 9 mm at 1 mm/s
reset
  0 s + guard: reset by N. N.
)");
}
