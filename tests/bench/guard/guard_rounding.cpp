// The guard's rounding of a ramp's steps, and what it knows of axes and forces at their edges.
#include <catch2/catch.hpp>
#include <optional>
#include <string>

#include "bench/common/process_time.h"
#include "bench/guard/guard.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::bench;
using devices::fault_id_of;
using devices::Psi;

namespace {

struct SteppingGuard {
  SteppingGuard() {
    limits.safety.step_psi = 2.5;
    limits.safety.rate_psi_per_s = 20.0;
    limits.axes.fill({0.0, 50.0, 8.0});
    guard.emplace(limits, clock);
    guard->arm();
    guard->source_armed();
    guard->note_feedback(Psi(0.0), clock.now());
    guard->note_reference(Psi(0.0), clock.now());
  }
  std::string asked(double psi) {
    const std::string id = fault_id_of([&] { guard->check_pressure(Psi(psi)); });
    if (id == "none") guard->set_pressure(Psi(psi));
    return id;
  }
  GuardLimits limits;
  devices::TurnedClock clock;
  std::optional<Guard> guard;
};

}  // namespace

TEST_CASE("guard's rounding: a step may be a billionth too long, not more") {
  CHECK(SteppingGuard().asked(2.5 * (1.0 + 0.9e-9)) == "none");
  CHECK(SteppingGuard().asked(2.5 * (1.0 + 1.1e-9)) == "TB-CHAMBER-RATE");
}

TEST_CASE("guard's rounding: what is left of a step grows with time and never beyond the step") {
  SteppingGuard bench;
  CHECK(bench.asked(1.0) == "none");
  CHECK(bench.asked(2.6) == "TB-CHAMBER-RATE");  // 1.5 psi are left
  CHECK(bench.asked(0.5) == "none");             // going down gives nothing back
  CHECK(bench.asked(2.1) == "TB-CHAMBER-RATE");
  CHECK(bench.asked(2.0) == "none");
  bench.clock.wait_until(seconds(0.05));
  CHECK(bench.asked(3.1) == "TB-CHAMBER-RATE");  // 1 psi in 50 ms
  CHECK(bench.asked(3.0) == "none");
  bench.clock.wait_until(seconds(0.9));
  CHECK(bench.asked(5.6) == "TB-CHAMBER-RATE");
  CHECK(bench.asked(5.5) == "none");
}

TEST_CASE("guard's rounding: a repeat at 0 psi is always free, and homing z is away from anything") {
  SteppingGuard bench;
  bench.guard->trip("TB-OTHER", "a cause");
  CHECK_NOTHROW(bench.guard->check_rewriting());
  const Guard::ReadAxis deep = [](devices::Axis) {
    devices::AxisState state;
    state.position = devices::Millimetres(40.0);
    state.homed = true;
    return state;
  };
  CHECK(fault_id_of([&] { bench.guard->check_home(devices::Axis::kZ, deep); }) == "none");
  CHECK(fault_id_of([&] { bench.guard->check_home(devices::Axis::kX, deep); }) == "TB-GUARD-TRIPPED");
  CHECK(fault_id_of([&] { bench.guard->check_move(devices::Axis::kZ, 40.0, 1.0, deep); }) == "none");
  CHECK(fault_id_of([&] { bench.guard->check_move(devices::Axis::kZ, 40.1, 1.0, deep); }) == "TB-GUARD-TRIPPED");
  CHECK(fault_id_of([&] { bench.guard->check_move(devices::Axis::kX, 1.0, 1.0, deep); }) == "TB-GUARD-TRIPPED");
}
