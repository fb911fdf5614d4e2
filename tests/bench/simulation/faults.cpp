// The schedule of faults, and what each does to chamber, stage and array. On the wires: faults_wire.cpp.
#include "bench/simulation/faults.h"

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <set>

#include "bench/simulation/plant.h"
#include "tests/bench/simulation/lone_stage.h"

namespace tactbench::bench {
namespace {

using devices::InjectedFault;
using devices::Nanoseconds;
using devices::Psi;
using devices::Volts;
using namespace std::chrono_literals;

struct Bench {
  explicit Bench(std::vector<PlannedFault> faults = {}) : plant(with(std::move(faults)), clock) {}
  static PlantOptions with(std::vector<PlannedFault> faults) {
    PlantOptions options;
    options.chamber.hysteresis_share = 0.0;
    options.faults = std::move(faults);
    return options;
  }
  void command(double psi) {
    plant.drive(Volts(psi / ChamberOptions().span_psi * 10.0), Nanoseconds::max(), Volts(0.0));
  }
  void wait(Nanoseconds time) { clock.wait_until(clock.now() + time); }
  double hold(double psi, Nanoseconds time = 3s) {
    command(psi);
    wait(time);
    return pressure();
  }
  double pressure() { return plant.true_pressure().value(); }
  double feedback() { return plant.feedback().value() / 10.0 * ChamberOptions().span_psi; }
  double reference() { return plant.reference_pressure().value(); }
  devices::TurnedClock clock;
  Plant plant;
};

PlannedFault planned(FaultKind kind) {
  PlannedFault fault;
  fault.kind = kind;
  return fault;
}

}  // namespace

TEST_CASE("faults: each kind has its own word") {
  const std::set<std::string> words(fault_words().begin(), fault_words().end());
  CHECK(words.size() == static_cast<std::size_t>(kFaultKinds));
  CHECK(fault_words()[static_cast<std::size_t>(FaultKind::kStageStalled)] == "stage_stalled");
  CHECK(fault_words().back() == "scanner_unplugged");
}

TEST_CASE("faults: by time, by pressure, by force, for a while, a number of times, until cleared") {
  PlannedFault at_time = planned(FaultKind::kLeak);
  at_time.at_s = 2.0;
  at_time.lasts_s = 1.0;
  at_time.value = 7.0;
  PlannedFault at_psi = planned(FaultKind::kValveStuck);
  at_psi.at_psi = 30.0;
  PlannedFault at_n = planned(FaultKind::kStageStalled);
  at_n.at_n = 10.0;
  PlannedFault twice = planned(FaultKind::kModuleSilent);
  twice.times = 2;
  Faults faults({at_time, at_psi, at_n, twice});
  CHECK_FALSE(faults.active(FaultKind::kLeak, 1999ms));
  CHECK(faults.active(FaultKind::kLeak, 2s) == 7.0);
  CHECK(faults.active(FaultKind::kLeak, 2999ms));
  CHECK_FALSE(faults.active(FaultKind::kLeak, 3s));
  faults.load(29.9, 9.9, 1s);
  CHECK_FALSE(faults.active(FaultKind::kValveStuck, 1s));
  faults.load(30.0, 9.9, 2s);
  faults.load(0.0, 10.0, 3s);
  CHECK(faults.active(FaultKind::kValveStuck, 2s));
  CHECK_FALSE(faults.active(FaultKind::kValveStuck, 1s));
  CHECK(faults.last(FaultKind::kStageStalled, 4s).from == Nanoseconds(3s));
  CHECK_FALSE(faults.last(FaultKind::kStageStalled, 2s).from);
  CHECK(faults.injected(Instrument::kScanner, 0s) == InjectedFault::kNone);
  CHECK(faults.injected(Instrument::kModule, 0s) == InjectedFault::kSilent);
  CHECK(faults.injected(Instrument::kModule, 0s) == InjectedFault::kSilent);
  CHECK(faults.injected(Instrument::kModule, 0s) == InjectedFault::kNone);
  faults.clear(FaultKind::kValveStuck, 5s);
  CHECK(faults.active(FaultKind::kValveStuck, 4s));
  CHECK_FALSE(faults.active(FaultKind::kValveStuck, 5s));
  faults.inject(planned(FaultKind::kValveStuck), 6s);
  CHECK(faults.active(FaultKind::kValveStuck, 6s));
}

TEST_CASE("faults: an empty plan gives no fault") {
  const Faults faults({});
  CHECK_FALSE(faults.any());
  CHECK_FALSE(faults.active(FaultKind::kLeak, 1s));
}

TEST_CASE("fault valve_stuck: the pressure stays, and follows again once it is cleared") {
  Bench bench;
  const double held = bench.hold(30.0);
  bench.plant.inject(FaultKind::kValveStuck);
  CHECK(bench.hold(0.0) == Approx(held).margin(0.05));
  CHECK(bench.reference() == Approx(held).margin(0.1));
  bench.plant.dump(true);  // the only way out
  bench.wait(500ms);
  CHECK(bench.pressure() == 0.0);
  bench.plant.dump(false);
  bench.plant.clear(FaultKind::kValveStuck);
  CHECK(bench.hold(20.0) == Approx(20.0).margin(0.25));
}

TEST_CASE("fault leak: it begins at the planned pressure, and the regulator compensates all but an offset") {
  PlannedFault leak = planned(FaultKind::kLeak);
  leak.at_psi = 25.0;
  leak.value = 5.0;
  Bench bench({leak});
  CHECK(bench.hold(20.0) == Approx(20.0).margin(0.2));
  CHECK(bench.hold(30.0) == Approx(30.0 - 2 * 0.75 * 0.12 * 5.0).margin(0.2));
  CHECK(bench.hold(20.0) == Approx(20.0 - 0.9).margin(0.2));  // it stays
}

TEST_CASE("fault overshoot: only the next level, by its size, at any time of the query") {
  const auto highest = [](bool again, int step_ms) {
    Bench bench;
    bench.hold(20.0);
    bench.plant.inject(FaultKind::kOvershoot, 3.0);
    if (again) bench.hold(22.0);
    const double level = again ? 24.0 : 22.0;
    bench.command(level);
    double most = 0.0;
    for (int i = 0; i < 3000 / step_ms; ++i) {
      bench.wait(std::chrono::milliseconds(step_ms));
      most = std::max(most, bench.pressure() - level);
    }
    CHECK(bench.pressure() == Approx(level).margin(0.25));
    return most;
  };
  CHECK(highest(false, 10) == Approx(3.0).epsilon(0.2));
  CHECK(highest(true, 10) < 0.5);
  CHECK(highest(false, 30) <= highest(false, 10));
}

TEST_CASE("fault supply_lost: no level above is reached, the supply reads 0, venting still works") {
  Bench bench;
  const double held = bench.hold(30.0);
  CHECK(bench.plant.supply_bar() == 8.0);
  bench.plant.inject(FaultKind::kSupplyLost, 0.5);
  CHECK(bench.plant.supply_bar() == 0.0);
  CHECK(bench.hold(40.0, 10s) == Approx(held - 5.0).margin(0.3));
  CHECK(bench.hold(0.0) == 0.0);
  bench.plant.clear(FaultKind::kSupplyLost);
  CHECK(bench.hold(40.0) == Approx(40.0).margin(0.25));
}

TEST_CASE("fault regulator_unpowered: 60 psi stay in the chamber while the monitor reads 0 V") {
  Bench bench;
  const double held = bench.hold(60.0, 5s);
  bench.plant.inject(FaultKind::kRegulatorUnpowered);
  bench.hold(0.0, 20s);
  CHECK(bench.plant.feedback() == Volts(0.0));
  CHECK(bench.reference() == Approx(held).margin(0.1));
  bench.plant.clear(FaultKind::kRegulatorUnpowered);
  bench.wait(5s);
  CHECK(bench.pressure() == Approx(0.0).margin(0.01));  // power brings the last command
}

TEST_CASE("faults feedback_offset and reference_offset: the two witnesses disagree") {
  Bench bench;
  bench.hold(30.0);
  bench.plant.inject(FaultKind::kFeedbackOffset, -8.0);
  CHECK(bench.feedback() == Approx(22.0).margin(0.3));
  CHECK(bench.reference() == Approx(30.0).margin(0.3));
  bench.plant.clear(FaultKind::kFeedbackOffset);
  bench.plant.inject(FaultKind::kReferenceOffset);
  CHECK(bench.feedback() == Approx(30.0).margin(0.3));
  CHECK(bench.reference() == Approx(40.0).margin(0.3));
}

TEST_CASE("fault row_stuck: that row's counts stay bit for bit, the others keep changing") {
  Bench bench;
  const auto scan = [&] {
    std::array<std::uint16_t, 256> counts{};
    std::array<std::uint8_t, 16> status{};
    bench.plant.scan(counts, status);
    return counts;
  };
  const auto row = [](const std::array<std::uint16_t, 256>& counts, int number) {
    const auto* at = counts.data() + static_cast<std::ptrdiff_t>(16 * number);
    return std::vector<std::uint16_t>(at, at + 16);
  };
  bench.hold(10.0);
  bench.plant.inject(FaultKind::kRowStuck, 5.0);
  const auto first = scan();
  bench.hold(30.0);
  const auto second = scan();
  CHECK(row(first, 5) == row(second, 5));
  CHECK(second[16 * 4] > first[16 * 4] + 1000);
  CHECK(second[16 * 6] > first[16 * 6] + 1000);
  bench.plant.clear(FaultKind::kRowStuck);
  CHECK(row(scan(), 5) != row(second, 5));
}

TEST_CASE("a stuck axis does not move but reports that it did, and homing corrects its position") {
  devices::ChainDevice device(devices::ChainDeviceOptions{});
  std::vector<devices::ZaberFrame> replies;
  Nanoseconds now{0};
  const auto go = [&](devices::ZaberCommand command, std::int32_t data) {
    replies.clear();
    device.receive({1, command, data, 0}, now, 1, replies);
    const auto end = device.due();
    if (end) now = *end;
    device.run(now, replies);
    return !replies.empty();
  };
  using enum devices::ZaberCommand;
  REQUIRE(go(kHome, 0));
  REQUIRE(go(kMoveAbsolute, 20000));
  const double stood = device.position(now).value();
  device.stick(now);
  CHECK(go(kMoveAbsolute, 60000));  // it says that it has arrived
  CHECK(replies.back().data == 60000);
  CHECK(device.position(now).value() == stood);
  CHECK_FALSE(go(kHome, 0));  // and seeks its home sensor in vain
  now += 10s;
  device.free(now);
  CHECK(device.position(now).value() == Approx(stood));
  now = device.due().value();
  device.run(now, replies);
  CHECK(device.position(now).value() == Approx(0.0).margin(1e-9));
  REQUIRE(go(kMoveAbsolute, 20000));
  CHECK(device.position(now).value() == Approx(stood).margin(1e-9));
  CHECK(device.position(now - 1h).value() >= 0.0);  // long ago: the oldest that is known
}

TEST_CASE("an axis reports its position at an earlier time") {
  devices::TurnedClock clock;
  LoneStage stage(clock);
  const Nanoseconds there = stage.go(devices::Axis::kX, 10.0);
  CHECK_FALSE(stage.at_rest_since(Nanoseconds(0)));
  clock.wait_until(there);
  const Nanoseconds back = stage.go(devices::Axis::kX, 2.0);
  clock.wait_until(back + 1s);
  CHECK(stage.places(Nanoseconds(0))[0].value() == 0.0);
  CHECK(stage.places(there)[0].value() == Approx(10.0).margin(1e-3));
  CHECK(stage.places(there / 2)[0].value() == Approx(5.0).margin(0.01));
  CHECK(stage.places(back)[0].value() == Approx(2.0).margin(1e-3));
  CHECK(stage.at_rest_since(back));
  CHECK_FALSE(stage.at_rest_since(back - 1ms));
}

TEST_CASE("faults: the same schedule gives the same run") {
  const auto run = [] {
    PlannedFault leak = planned(FaultKind::kLeak);
    leak.at_psi = 15.0;
    leak.lasts_s = 2.5;
    PlannedFault jump = planned(FaultKind::kOvershoot);
    jump.at_s = 5.0;
    Bench bench({leak, jump});
    for (const double psi : {10.0, 20.0, 30.0}) bench.hold(psi);
    return bench.plant.specimen_state();
  };
  CHECK(run() == run());
}

}  // namespace tactbench::bench
