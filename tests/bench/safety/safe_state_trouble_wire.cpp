// The safe state when instruments fail on the way to it: what is proved, the state of the rig, and how long it takes.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::FaultKind;
using db::SafeState;
using Settings = std::vector<sequences::Override>;

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
