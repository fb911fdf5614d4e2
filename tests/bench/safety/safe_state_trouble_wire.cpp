// The safe state when instruments fail on the way to it: what is proved, where the rig stands, how long it takes.
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

namespace {

struct Proved {
  SafeState state;
  std::string text;
  double took_s = 0.0, psi = 0.0, newtons = 0.0;  // process time, and where the rig stands then
};

class TroubledRig {
 public:
  TroubledRig() : rig(quick_bench()) {
    rig.open();
    baseline = bench::baseline_of(rig.array().read(8));
  }
  static bench::BenchConfig quick_bench() {
    return small_request(
               {{"limits.vent_timeout_s", "4"}, {"force.reply_timeout_ms", "200"}, {"stage.reply_timeout_ms", "100"}})
        .bench;
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
    return {proof.state, proof.text, devices::in_seconds(rig.clock().now() - begun),
            std::abs(rig.plant()->true_pressure().value()), std::abs(rig.plant()->wrench().force_n[2])};
  }
  bench::Rig rig;
  bench::Baseline baseline;
};

}  // namespace

TEST_CASE(
    "safe state in trouble: a module that refuses a few times is asked again, one that refuses for good is not "
    "waited for") {
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

TEST_CASE(
    "safe state in trouble: a valve that is stuck has failed, once free it is proved, and a wrong witness is not "
    "believed") {
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

TEST_CASE(
    "safe state in trouble: pressed, with all well, without force, without the stage's replies, with a stalled "
    "axis") {
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
                                        {FaultKind::kStageStalled, 3.0, SafeState::kFailed, 15.0, 2.0}}));
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
