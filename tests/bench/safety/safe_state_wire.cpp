#include "bench/safety/safe_state.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "bench/safety/ramp.h"
#include "bench/simulation/plant.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using Settings = std::vector<sequences::Override>;
using bench::FaultKind;
using db::SafeState;
using devices::Axis;
using devices::fault_id_of;
using devices::Millimetres;
using devices::Psi;

namespace {

// The safe state of a rig that was never loaded, after an unloaded frame that is lower by `less` counts than it is.
SafeProof proof_of(const Settings& settings, double less, bool independent = true) {
  BenchConfig config = small_request(settings).bench;
  config.reference_independent = independent;
  Rig rig(config);
  rig.open();
  UnloadedFrame baseline = unloaded_frame_of(rig.array().read(8));
  for (double& counts : baseline) counts -= less;
  return make_safe(rig, baseline);
}

}  // namespace

TEST_CASE("safe state: a silent module vents by its watchdog and is reported as unverified") {
  // bring-up, ramp and 4 s of feeding take fewer than 160 requests; then nothing answers.
  Rig rig(small_request(
              {{"simulation.wire_faults.module_silent_after_requests", "160"}, {"module.response_timeout_ms", "300"}})
              .bench);
  rig.open();
  (void)ramp_to(rig, devices::Psi(40.0));
  const auto feed = [&](int times) {
    for (int i = 0; i < times; ++i) {
      rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(200));
      rig.source().keep_alive();
    }
  };
  feed(20);
  REQUIRE(rig.plant()->true_pressure().value() == Approx(40.0).margin(1.0));
  CHECK_THROWS_AS(feed(100), std::exception);
  CHECK(make_safe(rig, {}).state == db::SafeState::kUnverified);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
}

TEST_CASE("safe state: each witness is compared with the limit, and its reading is reported") {
  const auto offset = [](const char* span) {
    return Settings{{"reference.span_psi", span}, {"limits.vent_timeout_s", "3"}};
  };
  const SafeProof sound = proof_of({}, 0.0);
  CHECK(sound.state == db::SafeState::kVerified);
  const SafeProof below = proof_of(offset("[0.7, 100]"), 0.0);  // [limits] safe_psi is 1
  CHECK(below.state == db::SafeState::kVerified);
  CHECK_THAT(below.text.in(tactbench::analysis::PressureUnit::kPsi),
             Catch::Contains("0.0 psi") && Catch::Contains("0.7 psi"));
  const SafeProof above = proof_of(offset("[1.3, 100]"), 0.0);  // the array may bear witness, and cannot outvote it
  CHECK(above.state == db::SafeState::kFailed);
  CHECK_THAT(above.text.in(tactbench::analysis::PressureUnit::kPsi),
             Catch::StartsWith("NOT SAFE") && Catch::Contains("1.3 psi"));
}

TEST_CASE(
    "safe state: not proved if the array reads more than 2 % of the converter range, even if pressures are zero") {
  const SafeProof within = proof_of({}, 0.019 * 65535.0);
  CHECK(within.state == db::SafeState::kVerified);
  const SafeProof beyond = proof_of({}, 0.021 * 65535.0);
  CHECK(beyond.state == db::SafeState::kUnverified);
  CHECK(proof_of({}, -20000.0).state == db::SafeState::kVerified);  // the unloaded frame itself still relaxed
}

TEST_CASE("safe state: without an independent reference the array is the second witness") {
  const SafeProof both = proof_of({}, 0.0, false);
  CHECK(both.state == db::SafeState::kVerified);
  const SafeProof loaded = proof_of({}, 0.021 * 65535.0, false);
  CHECK(loaded.state == db::SafeState::kFailed);
  BenchConfig dependent = small_request().bench;
  dependent.reference_independent = false;
  Rig rig(dependent);
  rig.open();
  const SafeProof alone = make_safe(rig, {});  // no unloaded frame to compare with
  CHECK(alone.state == db::SafeState::kUnverified);
}

TEST_CASE("safe state: the unloaded frame is the mean of eight scans, and half of the taxels decide") {
  Rig rig(small_request().bench);
  rig.open();
  const auto proof = [&](std::size_t loaded) {
    UnloadedFrame baseline = unloaded_frame_of(rig.array().read(8));
    for (std::size_t i = 0; i < loaded; ++i) baseline[i] -= 20000.0;
    return make_safe(rig, baseline).state;
  };
  CHECK(proof(120) == db::SafeState::kVerified);
  CHECK(proof(136) == db::SafeState::kUnverified);
}

// The safe state when instruments fail on the way to it: what is proved, the state of the rig, and how long it takes.

namespace {

struct Proved {
  SafeState state;
  std::string text;
  double took_s = 0.0, psi = 0.0, newtons = 0.0;  // process time, and the state of the rig then
};

class TroubledRig {
 public:
  explicit TroubledRig(const Settings& more = {}) : rig(quick_bench(more)) {
    rig.open();
    baseline = bench::unloaded_frame_of(rig.array().read(8));
  }
  static bench::BenchConfig quick_bench(Settings settings) {
    settings.insert(settings.end(), {{"limits.vent_timeout_s", "4"},
                                     {"module.response_timeout_ms", "100"},
                                     {"force.reply_timeout_ms", "200"},
                                     {"stage.reply_timeout_ms", "100"}});
    return small_request(settings).bench;
  }
  void load(double psi) {
    (void)ramp_to(rig, devices::Psi(psi));
    for (int i = 0; i < 15; ++i) {
      rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(200));
      rig.source().keep_alive();
    }
  }
  // With about 20 N a millimetre below 30 mm.
  void press(double z_mm) {
    devices::Stage& stage = *rig.stage_gate();
    stage.arm();
    for (const auto axis : {devices::Axis::kZ, devices::Axis::kX, devices::Axis::kY}) stage.home(axis);
    devices::ForceSensor& force = rig.open_force();
    for (const auto axis : {devices::Axis::kX, devices::Axis::kY}) {
      stage.start_move_to(axis, devices::Millimetres(30.0), std::nullopt);
      (void)stage.wait(axis);
    }
    (void)force.bias(20);
    (void)force.read(20);
    stage.start_move_to(devices::Axis::kZ, devices::Millimetres(z_mm), std::nullopt);
    (void)stage.wait(devices::Axis::kZ);
  }
  void fail(FaultKind kind, std::optional<double> value = std::nullopt, long times = 0) {
    rig.plant()->inject(kind, value, times);
  }
  Proved prove() {
    const auto begun = rig.clock().now();
    const bench::SafeProof proof = make_safe(rig, baseline);
    return {proof.state, proof.text.in(tactbench::analysis::PressureUnit::kPsi),
            devices::in_seconds(rig.clock().now() - begun), std::abs(rig.plant()->true_pressure().value()),
            std::abs(rig.plant()->wrench().force_n[2])};
  }
  bench::Rig rig;
  bench::UnloadedFrame baseline;
};

}  // namespace

TEST_CASE("safe state in trouble: a module that refuses a few times is retried, one that always refuses is given up") {
  TroubledRig bench;
  for (const int refusals : {2, 5}) {
    if (refusals == 5) bench.rig.source().arm();
    bench.load(20.0);
    bench.fail(FaultKind::kModuleException, std::nullopt, refusals);
    const Proved some = bench.prove();
    CHECK(some.state == SafeState::kVerified);
    CHECK(some.psi < 1.0);
    CHECK(some.took_s < 1.0);
    CHECK(bench.prove().state == SafeState::kVerified);  // callable twice
  }
  bench.fail(FaultKind::kModuleException);
  const Proved never = bench.prove();
  CHECK(never.state == SafeState::kUnverified);
  CHECK(never.psi < 1.0);
  CHECK(never.took_s < 5.0);
}

TEST_CASE("safe state in trouble: a stuck valve fails, a freed one is proved, and a wrong witness is not believed") {
  TroubledRig bench;
  bench.load(20.0);
  bench.fail(FaultKind::kValveStuck);
  const Proved stuck = bench.prove();
  CHECK(stuck.state == SafeState::kFailed);
  CHECK_THAT(stuck.text, Catch::StartsWith("NOT SAFE") && Catch::Contains("20.0 psi"));
  CHECK(stuck.took_s == Approx(4.0).margin(0.3));  // [limits] vent_timeout_s
  CHECK(stuck.psi > 19.0);
  bench.rig.plant()->clear(FaultKind::kValveStuck);
  const Proved free = bench.prove();
  CHECK(free.state == SafeState::kVerified);
  CHECK((free.psi < 1.0 && free.took_s < 1.0));
  for (double& counts : bench.baseline) counts -= 20000.0;  // which the array never comes down to
  const Proved loaded = bench.prove();
  CHECK(loaded.state == SafeState::kUnverified);
  CHECK(loaded.took_s > 5.0);
  CHECK(loaded.took_s < 15.0);
}

TEST_CASE("safe state in trouble: pressing, with no fault, no force, no stage replies, or a stalled axis") {
  struct Row {
    std::optional<FaultKind> kind;
    std::optional<double> value;
    SafeState state;
    double most_n, most_s;
  };
  const Row row = GENERATE(values<Row>({{{}, {}, SafeState::kVerified, 0.5, 2.0},
                                        {FaultKind::kForceSilent, {}, SafeState::kUnverified, 0.5, 3.0},
                                        {FaultKind::kStageSilent, {}, SafeState::kUnverified, 0.5, 10.0},
                                        {FaultKind::kStageStalled, 1.0, SafeState::kVerified, 0.5, 2.0},  // x stays
                                        {FaultKind::kStageStalled, 3.0, SafeState::kFailed, 15.0, 20.0}}));
  TroubledRig bench;
  bench.press(30.5);
  REQUIRE(std::abs(bench.rig.plant()->wrench().force_n[2]) > 10.0);
  if (row.kind) bench.fail(*row.kind, row.value);
  const Proved proved = bench.prove();
  INFO(proved.text);
  CHECK(proved.state == row.state);
  CHECK(proved.psi < 1.0);
  CHECK(proved.newtons < row.most_n);
  CHECK((proved.newtons > 0.5) == (row.state == SafeState::kFailed));
  CHECK((proved.text.find("NOT SAFE") != std::string::npos) ==
        (row.kind == FaultKind::kStageSilent || row.state == SafeState::kFailed));
  CHECK(proved.took_s < row.most_s);
}

// What fails at 40 psi, and what is then proved, with the array there and without it. The truth is the plant's.
TEST_CASE("safe state in trouble: result for each combination of faulty witnesses") {
  struct Failing {
    FaultKind kind;
    std::optional<double> value = std::nullopt;
  };
  struct Row {
    const char* name;
    std::vector<Failing> failing;
    bool vents;  // the chamber in truth
    SafeState with_array, alone;
  };
  // A supply lost behind a live zero reads far below 0; a dump valve vents past a regulator without power, whose
  // monitor then shows 0 V, that is 0 psi, and stands still.
  const FaultKind feedback = FaultKind::kFeedbackOffset, reference = FaultKind::kReferenceOffset;
  const Failing stuck{FaultKind::kValveStuck}, unpowered{FaultKind::kRegulatorUnpowered};
  constexpr auto kYes = SafeState::kVerified, kUnproved = SafeState::kUnverified, kNo = SafeState::kFailed;
  const Row rows[] = {
      {"all well", {}, true, kYes, kYes},
      {"two dead", {{feedback, -90}, {reference, -90}}, true, kUnproved, kUnproved},
      {"two dead, loaded", {{feedback, -90}, {reference, -90}, stuck}, false, kNo, kUnproved},
      {"two 3 psi below zero, loaded", {{feedback, -43}, {reference, -43}, stuck}, false, kNo, kUnproved},
      // 24 V are lost: the monitor shows 0 V, a loop of 4-20 mA nothing, and the regulator keeps its pressure.
      {"two without supply, loaded", {{feedback, -40}, {reference, -65}, stuck}, false, kNo, kUnproved},
      {"feedback dead", {{feedback, -90}}, true, kYes, kUnproved},
      {"feedback dead, loaded", {{feedback, -90}, stuck}, false, kNo, kNo},
      {"reference dead", {{reference, -90}}, true, kYes, kUnproved},
      {"reference dead, loaded", {{reference, -90}, stuck}, false, kNo, kNo},
      {"feedback frozen at 0", {unpowered}, true, kYes, kUnproved},
      // Nothing shows that it is frozen; only the array would contradict it.
      {"feedback frozen at 0, reference dead", {unpowered, {reference, -90}}, true, kYes, kUnproved},
      {"all frozen", {{FaultKind::kModuleStale}}, true, kNo, kNo},  // at 40 psi
      {"feedback 2 psi low", {{feedback, -2}}, true, kYes, kUnproved},
      {"reference 2 psi low", {{reference, -2}}, true, kYes, kUnproved},
      {"both 2 psi low", {{feedback, -2}, {reference, -2}}, true, kUnproved, kUnproved},
      {"reference 2 psi high", {{reference, 2}}, true, kNo, kNo},
      {"reference far beyond its span", {{reference, 400}}, true, kNo, kNo},
  };
  for (const Row& row : rows) {
    for (const bool array : {true, false}) {
      const bool past_the_regulator =
          std::ranges::any_of(row.failing, [&](const Failing& one) { return one.kind == unpowered.kind; });
      TroubledRig bench(Settings{{"module.dump_coil", past_the_regulator ? "0" : "-1"}});
      bench.load(40.0);
      for (const Failing& failing : row.failing) bench.fail(failing.kind, failing.value);
      if (!array) bench.rig.close_array();
      const Proved proved = bench.prove();
      INFO(row.name << (array ? ", with the array: " : ", without it: ") << proved.text);
      CHECK(proved.state == (array ? row.with_array : row.alone));
      CHECK((proved.psi < 1.0) == row.vents);
    }
  }
}

TEST_CASE("safe state in trouble: twenty good benches with zero errors up to 1 % of span are verified") {
  for (int i = 0; i < 20; ++i) {
    const double share = 0.01 * (2.0 * (i % 5) / 4.0 - 1.0);  // -1 % to 1 %
    const double span_psi = 60.0 + 20.0 * (i / 5);
    const double most = 0.9;  // [limits] safe_psi is 1
    const double feedback_psi = std::min(share * 130.5, most), reference_psi = std::min(-share * span_psi, most);
    const std::string span = fmt::format("{}", span_psi);
    TroubledRig bench(Settings{{"reference.span_psi", "[0, " + span + "]"},
                               {"simulation.chamber.reference_span_psi", span},
                               {"simulation.faults", fmt::format("[{{kind='feedback_offset', value={}}}, "
                                                                 "{{kind='reference_offset', value={}}}]",
                                                                 feedback_psi, reference_psi)},
                               {"reference.expanded_uncertainty_psi", i % 2 == 0 ? "0.05" : "0"}});
    bench.load(30.0);
    if (i % 3 == 0) bench.rig.close_array();
    const Proved proved = bench.prove();
    INFO(feedback_psi << " psi and " << reference_psi << " psi off: " << proved.text);
    CHECK(proved.state == SafeState::kVerified);
  }
}

// A module that is lost at 30 psi: what the bench file says of it decides whether that can end verified.
TEST_CASE("safe state in trouble: a module without watchdog keeps its last set-point, and no watchdog is promised") {
  const Settings none = {{"module.profile", "generic"}, {"module.watchdog_ms", "0"}};
  const auto of = [](const char* profile, Settings more = {}) {
    more.insert(more.end(), {{"module.profile", profile}, {"module.watchdog_ms", "0"}});
    return more;
  };
  using Lost = std::pair<Settings, FaultKind>;
  for (const auto& [settings, kind] :
       {Lost{{}, FaultKind::kModuleSilent}, Lost{none, FaultKind::kModuleSilent},
        Lost{of("advantech-adam-6024"), FaultKind::kModuleUnplugged},
        Lost{of("moxa-iologik-e1241", {{"input_module.profile", "moxa-iologik-e1240"}, {"input_module.unit", "2"}}),
             FaultKind::kModuleSilent}}) {
    const bool watchdog = settings.empty();
    TroubledRig bench(settings);
    bench.load(30.0);
    bench.fail(kind);
    const Proved lost = bench.prove();
    INFO(lost.text);
    CHECK(lost.state == (watchdog ? SafeState::kUnverified : SafeState::kFailed));
    CHECK((lost.psi < 1.0) == watchdog);
    CHECK((lost.text.find("watchdog") != std::string::npos) == watchdog);
  }
  // Empty, by the array: still not the safe state, for the set-point may be anything.
  TroubledRig bench(none);
  bench.fail(FaultKind::kModuleSilent);
  CHECK(bench.prove().state == SafeState::kUnverified);
}

TEST_CASE("safe state in trouble: if 0 V does not vent, the voltage of 0 psi does, and a lost module is never safe") {
  const Settings vacuum = {{"regulator.span_bar", "[-1, 9]"}, {"regulator.relief", "'vacuum breaker VB-1'"}};
  TroubledRig bench(vacuum);
  CHECK(bench.prove().state == SafeState::kVerified);
  bench.rig.source().arm();
  bench.load(30.0);
  const Proved vented = bench.prove();
  CHECK(vented.state == SafeState::kVerified);
  CHECK(bench.rig.plant()->true_pressure().value() == Approx(0.0).margin(0.5));  // 0 V would be -14.5 psi
  CHECK_THAT(vented.text, Catch::Contains("VB-1") && Catch::Contains("-14.5 psi"));
  bench.fail(FaultKind::kModuleUnplugged);
  const Proved lost = bench.prove();
  INFO(lost.text);
  CHECK(lost.state == SafeState::kUnverified);
  CHECK_THAT(lost.text, Catch::Contains("VB-1"));
  CHECK(bench.rig.plant()->true_pressure().value() < -10.0);
}

// The guard on a whole simulated rig: the effect of a trip on the plant, and that no command bypasses the guard.

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
