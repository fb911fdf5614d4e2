// The safe state when instruments fail on the way to it: its words, and how long it takes, as they were recorded.
#include <fmt/format.h>

#include <cmath>
#include <regex>

#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::FaultKind;

namespace {

// Its lines: state, words and process time of each proof, and where the rig stands then.
class TroubledRig {
 public:
  explicit TroubledRig(std::vector<sequences::Override> changes = {}) : rig(bench_with(std::move(changes))) {
    rig.open();
    baseline = bench::baseline_of(rig.array().read(8));
  }
  static bench::BenchConfig bench_with(std::vector<sequences::Override> changes) {
    changes.push_back({"limits.vent_timeout_s", "4"});
    changes.push_back({"force.reply_timeout_ms", "200"});
    changes.push_back({"stage.reply_timeout_ms", "100"});
    return small_request(changes).bench;
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
  void prove(const std::string& name) {
    const auto begun = rig.clock().now();
    const bench::SafeProof proof = make_safe(rig, baseline);
    static const std::regex kPort("port [0-9]+");
    lines.push_back(fmt::format(
        "{}: {}, {} | after {} s, {:.2f} psi, {:.2f} N", name, to_string(proof.state),
        std::regex_replace(proof.text, kPort, "port N"), to_millisecond((rig.clock().now() - begun).count()),
        std::abs(rig.plant()->true_pressure().value()), std::abs(rig.plant()->wrench().force_n[2])));
  }
  bench::Rig rig;
  bench::Baseline baseline;
  std::vector<std::string> lines;
};

}  // namespace

TEST_CASE("safe state in trouble: the module refuses a few times, for long, or for good, line by line") {
  TroubledRig bench;
  bench.load(20.0);
  bench.fail(FaultKind::kModuleException, std::nullopt, 2);
  bench.prove("two refusals");
  bench.rig.source().arm();
  bench.load(20.0);
  bench.fail(FaultKind::kModuleException, std::nullopt, 5);
  bench.prove("five refusals");
  bench.fail(FaultKind::kModuleException);
  bench.prove("refused for good");
  check_lines(bench.lines, R"(
two refusals: verified, vented, verified (feedback 0.0 psi, reference 0.0 psi) | after 0.600 s, 0.00 psi, 0.00 N
five refusals: verified, vented, verified (feedback 0.0 psi, reference 0.0 psi) | after 0.600 s, 0.00 psi, 0.00 N
refused for good: unverified, vent NOT verified (the module did not take the order; its watchdog sets 0 V when not fed; tactile array back at its unloaded baseline) | after 3.000 s, 0.00 psi, 0.00 N
)");
}

TEST_CASE("safe state in trouble: a valve that is stuck, and a film that recovers, line by line") {
  TroubledRig bench;
  bench.load(20.0);
  bench.fail(FaultKind::kValveStuck);
  bench.prove("stuck at 20 psi");
  bench.rig.plant()->clear(FaultKind::kValveStuck);
  bench.prove("free again");
  for (double& counts : bench.baseline) counts -= 20000.0;
  bench.prove("an array that never comes down");
  check_lines(bench.lines, R"(
stuck at 20 psi: failed, NOT SAFE: pressure remains (feedback 20.0 psi, reference 20.1 psi, tactile array still loaded) | after 4.000 s, 20.09 psi, 0.00 N
free again: verified, vented, verified (feedback 0.0 psi, reference 0.0 psi) | after 0.600 s, 0.00 psi, 0.00 N
an array that never comes down: unverified, vented, verified (feedback 0.0 psi, reference 0.0 psi); NOT verified: the tactile array is still loaded, so one of the witnesses is wrong | after 10.000 s, 0.00 psi, 0.00 N
)");
}

TEST_CASE("safe state in trouble: pressed, with all well, without force, without the stage's replies, line by line") {
  {
    TroubledRig bench;
    bench.press(30.5);
    bench.prove("pressed");
    check_lines(bench.lines, R"(
pressed: verified, vented, verified (feedback 0.0 psi, reference 0.0 psi); retracted, verified (z 25.000 mm, 0.00 N) | after 0.922 s, 0.00 psi, 0.00 N
)");
  }
  {
    TroubledRig bench;
    bench.press(30.5);
    bench.fail(FaultKind::kForceSilent);
    bench.prove("force is silent");
    check_lines(bench.lines, R"(
force is silent: unverified, vented, verified (feedback 0.0 psi, reference 0.0 psi); retracted, NOT verified: no force reading (z 25.000 mm, force not known; requesting 50 records from the sensor at 127.0.0.1 port N (UDP): 0 came within 207.143 ms) | after 1.336 s, 0.00 psi, 0.00 N
)");
  }
  {
    TroubledRig bench;
    bench.press(30.5);
    bench.fail(FaultKind::kStageSilent);
    bench.prove("stage is silent");
    check_lines(bench.lines, R"(
stage is silent: unverified, vented, verified (feedback 0.0 psi, reference 0.0 psi); NOT SAFE: a force stands on the indenter (z not known, 12.87 N; stage x (device 1) was queried for device id (50) 2 times and did not answer within 0.1 s each); z was sent home without hearing of it, 0.00 N then | after 5.680 s, 0.00 psi, 0.01 N
)");
  }
  {
    TroubledRig bench;
    bench.press(30.5);
    bench.fail(FaultKind::kStageStalled, 1.0);
    bench.prove("x is stalled, which need not move");
    check_lines(bench.lines, R"(
x is stalled, which need not move: verified, vented, verified (feedback 0.0 psi, reference 0.0 psi); retracted, verified (z 25.000 mm, 0.00 N) | after 0.922 s, 0.00 psi, 0.00 N
)");
  }
  {
    TroubledRig bench;
    bench.press(30.5);
    bench.fail(FaultKind::kStageStalled, 3.0);
    bench.prove("z is stalled");
    check_lines(bench.lines, R"(
z is stalled: failed, vented, verified (feedback 0.0 psi, reference 0.0 psi); NOT SAFE: a force stands on the indenter (z 25.000 mm, 12.79 N) | after 0.922 s, 0.00 psi, 12.80 N
)");
  }
}
