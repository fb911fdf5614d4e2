// The guard on a whole simulated rig: the effect of a trip on the plant, and that no command bypasses the guard.
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using devices::Axis;
using devices::fault_id_of;
using devices::Millimetres;
using devices::Psi;

namespace {

void wait(Rig& rig, double s) { rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(int(1000 * s))); }

void home(Rig& rig) {
  rig.stage_gate()->arm();
  for (const Axis axis : {Axis::kZ, Axis::kX, Axis::kY}) rig.stage_gate()->home(axis);
}

}  // namespace

TEST_CASE("guarded rig: measured pressure above the trip vents the chamber") {
  Rig rig(small_request({{"limits.trip_psi", "30"},
                         {"limits.command_psi", "30"},
                         {"regulator.span_bar", "[0, 9]"},
                         {"simulation.chamber.damping", "0.25"}})
              .bench);
  rig.open();
  std::string id;
  for (int i = 0; i < 50 && (id.empty() || id == "none"); ++i)
    id = fault_id_of([&] {
      ramp_to(rig, Psi(30.0));
      wait(rig, 0.1);
      (void)rig.source().feedback();
    });
  CHECK(id == "TB-CHAMBER-TRIP");
  for (int i = 0; i < 10; ++i) wait(rig, 0.5);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
  CHECK(fault_id_of([&] { (void)rig.source().command(Psi(1.0)); }) == "TB-GUARD-TRIPPED");
  CHECK(make_safe(rig, {}).state == db::SafeState::kVerified);
  rig.guard().reset("test");
  rig.source().arm();
  CHECK(fault_id_of([&] { ramp_to(rig, Psi(5.0)); }) == "none");
}

TEST_CASE("guarded rig: force above the limit halts the stage, and z may still retract") {
  Rig rig(small_request({{"limits.force_n", "[5, 5, 20]"}}).bench);
  home(rig);
  devices::Stage& stage = *rig.stage_gate();
  devices::ForceSensor& force = rig.open_force();
  (void)force.bias(10);
  (void)force.read(10);
  stage.start_move_to(Axis::kZ, Millimetres(30.0), std::nullopt);
  (void)stage.wait(Axis::kZ);
  (void)force.read(10);
  stage.start_move_to(Axis::kZ, Millimetres(31.5), devices::MillimetresPerSecond(1.0));
  const std::string id = fault_id_of([&] {
    for (int i = 0; i < 100; ++i) {
      wait(rig, 0.1);
      (void)force.read(10);
    }
  });
  CHECK(id == "TB-FORCE-TRIP");
  CHECK(fault_id_of([&] { (void)stage.wait(Axis::kZ); }) == "TB-STAGE-HALTED");
  stage.arm();
  const double stands = stage.state(Axis::kZ).position.value();
  CHECK(stands > 30.6);
  CHECK(stands < 31.1);  // it did not go on
  CHECK(fault_id_of([&] { stage.start_move_by(Axis::kZ, Millimetres(0.1), std::nullopt); }) == "TB-GUARD-TRIPPED");
  CHECK(fault_id_of([&] { stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt); }) == "TB-GUARD-TRIPPED");
  stage.start_move_by(Axis::kZ, Millimetres(-5.0), std::nullopt);
  CHECK(stage.wait(Axis::kZ).value() == Approx(stands - 5.0).margin(0.01));
}

TEST_CASE("guarded rig: a press is rejected before the force sensor is tared") {
  Rig rig(small_request().bench);
  home(rig);
  (void)rig.open_force().read(10);
  CHECK(fault_id_of([&] { rig.stage_gate()->start_move_to(Axis::kZ, Millimetres(31.0), std::nullopt); }) ==
        "TB-FORCE-STALE");
}

TEST_CASE("guarded rig: in virtual time a dead-man fires if process time passes without progress") {
  Rig rig(small_request({{"module.watchdog_ms", "60000"}}).bench);
  rig.open();
  ramp_to(rig, Psi(20.0));
  rig.clock().reply_lost(std::chrono::milliseconds(1700));
  CHECK(fault_id_of([&] { rig.source().keep_alive(); }) == "none");
  rig.feed_dead_man();
  rig.clock().reply_lost(std::chrono::milliseconds(2000));
  CHECK(fault_id_of([&] { rig.source().keep_alive(); }) == "TB-DEADMAN-FIRED");
  for (int i = 0; i < 10; ++i) wait(rig, 0.5);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
}

TEST_CASE("guarded rig: a ramp goes in ticks in both directions, the last one shorter, and each tick calls the hooks") {
  Rig rig(small_request().bench);
  rig.open();
  const SafetyLimits& limits = rig.config().limits;
  const double tick = ramp_tick_psi(limits, limits.rate_psi_per_s);
  CHECK(tick == 0.1 * limits.rate_psi_per_s);
  CHECK(ramp_tick_psi(limits, 1e6) == limits.step_psi);
  Psi setpoint(0.0);
  std::vector<double> at, stands_s;
  int firsts = 0, lasts = 0, before = 0;
  RampHooks hooks;
  hooks.before = [&](const RampTick& now) {
    ++before;
    firsts += now.first ? 1 : 0;
    CHECK(rig.guard().setpoint_psi() == setpoint.value());  // not commanded yet
    (void)rig.source().feedback();
    (void)rig.reference().read();
  };
  hooks.after = [&](const RampTick& now) {
    lasts += now.last ? 1 : 0;
    CHECK(rig.guard().setpoint_psi() == setpoint.value());
    at.push_back(setpoint.value());
    stands_s.push_back(now.seconds);
    wait(rig, 0.1);
  };
  const auto counts = ramp_to(rig, Psi(2.5 * tick), setpoint, tick, hooks);
  CHECK(at == std::vector<double>{tick, 2.0 * tick, 2.5 * tick});
  CHECK(stands_s == std::vector<double>{0.1, 0.1, 0.05});
  CHECK((firsts == 1 && lasts == 1 && before == 3));
  CHECK(ramp_to(rig, Psi(2.5 * tick), setpoint, tick, hooks) == counts);  // there already: one tick, of no time
  CHECK((at.size() == 4 && stands_s.back() == 0.0 && firsts == 2 && lasts == 2));
  at.clear();
  CHECK(ramp_to(rig, Psi(0.0), setpoint, tick, hooks) < counts);
  CHECK(at == std::vector<double>{1.5 * tick, 0.5 * tick, 0.0});
  // A rise larger than a tick by a billionth is one tick, a larger one is two.
  at.clear();
  (void)ramp_to(rig, Psi(tick * (1.0 + 0.9e-9)), setpoint, tick, hooks);
  CHECK(at.size() == 1);
  (void)ramp_to(rig, Psi(0.0), setpoint, 100.0, hooks);
  at.clear();
  (void)ramp_to(rig, Psi(tick * (1.0 + 1.1e-9)), setpoint, tick, hooks);
  CHECK(at.size() == 2);
  (void)ramp_to(rig, Psi(0.0), setpoint, 100.0, hooks);
  const Psi none(std::numeric_limits<double>::quiet_NaN());
  CHECK(fault_id_of([&] { ramp_to(rig, none, setpoint, tick, hooks); }) == "TB-CHAMBER-LIMIT");
  CHECK(fault_id_of([&] { ramp_to(rig, none); }) == "TB-CHAMBER-LIMIT");
  CHECK(rig.guard().setpoint_psi() == 0.0);
}

TEST_CASE("guarded rig: a ramp at the limits of the rig takes 0.1 s for each tick but the last") {
  Rig rig(small_request().bench);
  rig.open();
  int ticks = 0;
  const auto up = [&](double psi) {
    ticks = 0;
    wait(rig, 0.5);  // what the guard lets rise at once
    const auto begun = rig.clock().now();
    (void)ramp_to(rig, Psi(psi), [&] { ++ticks; });
    return std::chrono::round<std::chrono::milliseconds>(rig.clock().now() - begun).count();
  };
  const long quick = up(2.0);  // one tick: 20 psi/s for 0.1 s
  CHECK(ticks == 0);
  const long slow = up(7.0);
  CHECK(ticks == 2);
  CHECK(slow - quick >= 200);
  CHECK(slow - quick < 300);
  CHECK(rig.guard().setpoint_psi() == 7.0);
  (void)up(7.0);
  CHECK(ticks == 0);
  (void)up(1.0);  // down at once
  CHECK(ticks == 0);
  CHECK(rig.guard().setpoint_psi() == 1.0);
  wait(rig, 0.5);
  CHECK_NOTHROW(ramp_to(rig, Psi(3.0)));
}
