// The guard with drivers that record every call: what it lets through, in which order, and how it uses their readings.
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/guard/guard.h"
#include "bench/guard/guard_devices.h"
#include "tests/bench/run/press/press_rig.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using devices::Axis;
using devices::fault_id_of;
using devices::fault_of;
using devices::Millimetres;
using devices::MillimetresPerSecond;
using devices::Psi;
using std::chrono::milliseconds;

namespace {

using Calls = std::vector<std::string>;

class NotingSource final : public devices::PressureSource {
 public:
  explicit NotingSource(Calls& calls) : calls_(calls) {}
  void arm() override { calls_.push_back("arm"); }
  void disarm() noexcept override { calls_.push_back("disarm"); }
  bool armed() const override { return true; }
  std::uint16_t command(Psi pressure) override {
    calls_.push_back("command " + std::to_string(static_cast<int>(pressure.value())));
    return 77;
  }
  void keep_alive() override { calls_.push_back("keep_alive"); }
  devices::PressureReading feedback() override { return {Psi(psi), {}, 5, milliseconds(3)}; }
  devices::Nanoseconds last_fed() const override { return milliseconds(9); }
  bool vent() noexcept override {
    calls_.push_back("vent");
    return vents;
  }
  devices::Identity identity() const override { return {}; }
  std::uint64_t exchanges() const override { return 0; }
  double psi = 0.0;
  bool vents = true;

 private:
  Calls& calls_;
};

// Fires after so many questions; the line is free or not.
class CountingWatcher final : public Watcher {
 public:
  void feed() override { ++fed; }
  bool fired() override { return fires_at >= 0 && asked++ >= fires_at; }
  std::optional<WatcherLost> lost() override { return gone; }
  bool wait_ended(devices::Nanoseconds longest) override {
    waited.push_back(longest);
    return ends;
  }
  int fed = 0, asked = 0, fires_at = -1;
  bool ends = false;
  std::optional<WatcherLost> gone;
  std::vector<devices::Nanoseconds> waited;
};

struct Gate {
  Gate() {
    guard.set_log([this](devices::Nanoseconds, const std::string& actuator, const std::string& text, bool) {
      lines.push_back(actuator + ": " + text);
    });
    guard.set_actuators(&inner, &stage);
    guard.set_trip_sink([this](const Trip& trip) { stored.push_back(trip); });
    guard.set_run(12);
  }
  static GuardLimits limits() {
    GuardLimits limits;
    limits.safety.step_psi = 100.0;
    limits.axes.fill({1.0, 50.0, 8.0});
    return limits;
  }
  void ready() {
    source.arm();
    guard.note_feedback(Psi(0.0), clock.now());
    guard.note_reference(Psi(0.0), clock.now());
    calls.clear();
  }
  // The ids of the faults, "none" without; x, where no axis is named.
  std::string sent_to(Axis axis, double mm) {
    return fault_id_of([&] { gate.start_move_to(axis, Millimetres(mm), std::nullopt); });
  }
  std::string sent_by(double mm, double mm_per_s = 4.0) {
    return fault_id_of([&] { gate.start_move_by(Axis::kX, Millimetres(mm), MillimetresPerSecond(mm_per_s)); });
  }
  std::string sent_at(double mm_per_s) {
    return fault_id_of([&] { gate.start_speed(Axis::kX, MillimetresPerSecond(mm_per_s)); });
  }
  Calls calls, lines;
  std::vector<Trip> stored;
  devices::ManualClock clock;
  Guard guard{limits(), clock};
  IdealStage stage{clock};
  NotingSource inner{calls};
  GuardedSource source{std::make_unique<NotingSource>(calls), guard, [this] { calls.push_back("before"); }};
  GuardedStage gate{stage, guard, [this] { calls.push_back("before stage"); }};
};

}  // namespace

TEST_CASE("guard gate: arming runs its check first, then arms the driver, with the set-point at 0") {
  Gate gate;
  CHECK_FALSE(gate.guard.armed());
  gate.source.arm();
  CHECK(gate.calls == Calls{"before", "arm"});
  CHECK(gate.guard.armed());
  CHECK(gate.guard.setpoint_psi() == 0.0);
  GuardedSource refused(std::make_unique<NotingSource>(gate.calls), gate.guard, [] { throw std::runtime_error("no"); });
  gate.calls.clear();
  CHECK_THROWS(refused.arm());
  CHECK(gate.calls.empty());
}

TEST_CASE("guard gate: a command reaches the driver once and sets the set-point, a refused one is not sent") {
  Gate gate;
  gate.ready();
  CHECK(gate.source.command(Psi(20.0)) == 77);
  CHECK(gate.guard.setpoint_psi() == 20.0);
  CHECK(gate.calls == Calls{"command 20"});
  CHECK(fault_id_of([&] { (void)gate.source.command(Psi(61.0)); }) == "TB-CHAMBER-LIMIT");
  CHECK(gate.calls == Calls{"command 20"});
  CHECK(gate.guard.setpoint_psi() == 20.0);
  gate.source.keep_alive();
  CHECK(gate.calls.back() == "keep_alive");
  CHECK(gate.source.vent());
  CHECK(gate.guard.setpoint_psi() == 0.0);
  CHECK(gate.lines.back().starts_with("pressure: "));
  const std::size_t before = gate.lines.size();
  CHECK(gate.source.vent());  // once more: nothing to tell
  CHECK(gate.lines.size() == before);
}

TEST_CASE("guard gate: a vent that is not confirmed keeps the set-point, and is reported each time") {
  Gate gate;
  auto driver = std::make_unique<NotingSource>(gate.calls);
  driver->vents = false;
  GuardedSource source(std::move(driver), gate.guard, [] {});
  source.arm();
  gate.guard.note_feedback(Psi(0.0), gate.clock.now());
  gate.guard.note_reference(Psi(0.0), gate.clock.now());
  (void)source.command(Psi(10.0));
  CHECK_FALSE(source.vent());
  CHECK(gate.guard.setpoint_psi() == 10.0);
  CHECK(gate.lines.back().starts_with("pressure: "));
  const std::size_t before = gate.lines.size();
  CHECK_FALSE(source.vent());
  CHECK(gate.lines.size() == before + 1);
}

TEST_CASE("guard gate: a dead-man that fires between check and write is detected after it, and the chamber is vented") {
  for (const bool rewriting : {false, true}) {
    Gate gate;
    gate.ready();
    CountingWatcher watcher;
    gate.guard.set_watcher(&watcher);
    (void)gate.source.command(Psi(20.0));
    gate.calls.clear();
    watcher.asked = 0;
    watcher.fires_at = 1;  // not before the writing
    const std::string id = fault_id_of([&] {
      if (rewriting) {
        gate.source.keep_alive();
      } else {
        (void)gate.source.command(Psi(21.0));
      }
    });
    CHECK(id == "TB-DEADMAN-FIRED");
    CHECK(gate.calls == Calls{rewriting ? "keep_alive" : "command 21", "vent"});
    CHECK(watcher.waited.front() == milliseconds(0));
    CHECK(gate.stored.size() == 1);
  }
}

TEST_CASE("guard gate: a trip vents, halts an armed stage and is stored with its run, only the first one counts") {
  Gate gate;
  gate.ready();
  gate.guard.trip("TB-A", "first");
  CHECK(gate.calls == Calls{"vent"});
  CHECK(gate.stage.halts == 0);  // it was never armed
  gate.guard.trip("TB-B", "second");
  REQUIRE(gate.stored.size() == 1);
  CHECK((gate.stored[0].id == "TB-A" && gate.stored[0].what == "first" && gate.stored[0].run == 12));
  CHECK_THAT(gate.lines.back(), Catch::StartsWith("guard: ") && Catch::Contains("TB-A") && Catch::Contains("first"));
  gate.guard.reset("somebody");
  CHECK_THAT(gate.lines.back(), Catch::StartsWith("guard: ") && Catch::Contains("somebody"));
  gate.gate.arm();
  CHECK(gate.calls.back() == "before stage");
  gate.guard.trip("TB-C", "third");
  CHECK(gate.stage.halts == 1);
  gate.guard.reset("somebody");
  CountingWatcher watcher;
  gate.guard.set_watcher(&watcher);
  gate.guard.feed();
  CHECK(watcher.fed == 1);
  gate.guard.trip(kDeadManFired, "it works on the line");
  CHECK(gate.stage.halts == 1);
  gate.guard.reset("somebody");
  watcher.ends = true;
  gate.guard.trip(kDeadManFired, "it has ended");
  CHECK(gate.stage.halts == 2);
}

TEST_CASE("guard gate: a lost dead-man trips once with its own cause, and z may still retract") {
  Gate gate;
  gate.ready();
  gate.gate.arm();
  gate.stage.put(Axis::kZ, 10.0);
  (void)gate.source.command(Psi(2.0));
  CountingWatcher watcher;
  watcher.gone = WatcherLost{"TB-DEADMAN-BLIND", "it sees nothing", "Give it eyes."};
  gate.guard.set_watcher(&watcher);
  for (const Axis axis : {Axis::kZ, Axis::kX}) {
    const auto fault = fault_of([&] { gate.gate.start_move_to(axis, Millimetres(20.0), std::nullopt); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-DEADMAN-BLIND");
    CHECK_THAT(fault->what(), Catch::Contains("it sees nothing"));
    CHECK(as_error(std::make_exception_ptr(*fault)).remedy() == "Give it eyes.");
  }
  CHECK(gate.sent_to(Axis::kZ, 9.0) == "none");
  CHECK(fault_id_of([&] { (void)gate.source.command(Psi(1.0)); }) == "TB-DEADMAN-BLIND");
  CHECK(fault_id_of([&] { gate.gate.home(Axis::kZ); }) == "none");
  CHECK(gate.guard.may_use_stage_line());  // it does not work on the line: nobody waits for it
  REQUIRE(gate.stored.size() == 1);
  CHECK((gate.stored[0].id == "TB-DEADMAN-BLIND" && gate.stored[0].run == 12));
  CHECK(gate.stage.halts == 1);
  gate.guard.reset("somebody");
  CHECK_FALSE(gate.guard.tripped());
}

TEST_CASE("guard gate: a halt waits at most 15 s for a dead-man that uses the line, and leaves the stage to it") {
  Gate gate;
  CHECK(gate.gate.halt());
  CountingWatcher watcher;
  gate.guard.set_watcher(&watcher);
  CHECK(gate.gate.halt());
  CHECK(watcher.waited.empty());
  watcher.fires_at = 0;
  CHECK_FALSE(gate.gate.halt());
  CHECK(watcher.waited == std::vector<devices::Nanoseconds>{std::chrono::seconds(15)});
  CHECK(gate.stage.halts == 2);
  watcher.ends = true;
  CHECK(gate.gate.halt());
  gate.stage.obeys = false;
  CHECK_FALSE(gate.gate.halt());
}

TEST_CASE("guard gate: each kind of stage move is checked by its end position and its speed") {
  Gate gate;
  gate.gate.arm();
  gate.stage.put(Axis::kZ, 10.0);
  gate.gate.start_move_to(Axis::kZ, Millimetres(12.0), std::nullopt);
  CHECK(gate.sent_to(Axis::kX, 5.0) == "TB-STAGE-ENVELOPE");
  CHECK(gate.gate.wait(Axis::kZ).value() == 12.0);
  gate.gate.start_move_to(Axis::kX, Millimetres(5.0), std::nullopt);
  CHECK(gate.stage.mm(Axis::kX) == 0.0);
  CHECK(gate.sent_to(Axis::kZ, 26.0) == "TB-STAGE-ENVELOPE");
  CHECK(gate.gate.wait(Axis::kX).value() == 5.0);
  gate.stage.put(Axis::kX, 45.0);
  CHECK(gate.sent_by(5.1) == "TB-STAGE-LIMIT");
  CHECK(gate.sent_by(-44.1) == "TB-STAGE-LIMIT");
  CHECK(gate.sent_by(5.0, 8.1) == "TB-STAGE-LIMIT");
  CHECK(gate.sent_by(5.0, 8.0) == "none");
  CHECK(gate.gate.stop(Axis::kX).value() == 45.0);
  CHECK(gate.sent_at(-8.0) == "none");
  CHECK_THAT(gate.lines.back(),
             Catch::StartsWith("stage x: ") && Catch::Contains(" 1 mm ") && Catch::Contains("8 mm/s"));
  (void)gate.gate.stop(Axis::kX);
  CHECK(gate.sent_at(4.0) == "none");
  CHECK_THAT(gate.lines.back(),
             Catch::StartsWith("stage x: ") && Catch::Contains(" 50 mm ") && Catch::Contains("4 mm/s"));
  CHECK(gate.sent_at(0.0) == "TB-STAGE-LIMIT");
  (void)gate.gate.stop(Axis::kX);
  gate.gate.home(Axis::kZ);
  CHECK(gate.stage.homed_order == std::vector<Axis>{Axis::kZ});
  CHECK(gate.lines.back().starts_with("stage z: "));
  gate.gate.start_move_by(Axis::kZ, Millimetres(2.0), std::nullopt);
  gate.gate.arm();  // what moved before is not known to move
  CHECK(fault_id_of([&] { gate.gate.home(Axis::kX); }) == "none");
}

TEST_CASE("guard gate: force is checked from the first tare on, an overload of the sensor is a trip") {
  Gate gate;
  gate.gate.arm();
  auto inner = std::make_unique<IdealForce>(gate.clock, gate.stage, [](double) { return 40.0; });
  IdealForce& sensor = *inner;
  GuardedForce force(std::move(inner), gate.guard);
  CHECK(force.read(10).records == 10);  // 40 N before the tare
  CHECK_FALSE(gate.guard.tripped());
  CHECK(force.bias(25).wrench.force_n[2] == 0.0);
  CHECK(sensor.biased_by == 25);
  check_press_fault([&] { (void)force.read(10); }, "TB-FORCE-TRIP", {"Fx = 10.00 N", "5 N"});
  CHECK(gate.stage.halts == 1);
  CHECK_NOTHROW((void)force.read(10));  // tripped once: noted
  for (const auto& [id, trips] : {std::pair{"TB-FORCE-OVERLOAD", true}, std::pair{"TB-FORCE-SATURATED", true},
                                  std::pair{"TB-FORCE-TIMEOUT", false}}) {
    gate.guard.reset("test");
    sensor.law = [id = id](double) -> double { throw devices::Fault(id, "sensor", "said so", "look"); };
    CHECK(fault_id_of([&] { (void)force.read(10); }) == (trips ? "TB-FORCE-TRIP" : id));
    CHECK(gate.guard.tripped().has_value() == trips);
  }
}

TEST_CASE("feeding clock: feeds before, between and after slices, and not beyond the requested time") {
  devices::ManualClock inner;
  std::vector<devices::Nanoseconds> fed;
  FeedingClock clock(inner, milliseconds(100), [&] { fed.push_back(inner.now()); });
  clock.wait_until(milliseconds(250));
  using Times = std::vector<devices::Nanoseconds>;
  CHECK(fed == Times{milliseconds(0), milliseconds(100), milliseconds(200), milliseconds(250)});
  CHECK(clock.now() == milliseconds(250));
  fed.clear();
  clock.wait_until(milliseconds(250));
  CHECK(fed == Times{milliseconds(250)});
  clock.reply_lost(milliseconds(50));
  CHECK(clock.now() == milliseconds(300));
}
