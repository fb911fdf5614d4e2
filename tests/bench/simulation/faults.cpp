// The schedule of faults, and what each does to chamber, stage and array. On the wires: faults_wire.cpp.
#include "bench/simulation/faults.h"

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <set>

#include "bench/simulation/plant.h"

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
  devices::ManualClock clock;
  Plant plant;
};

PlannedFault planned(FaultKind kind) {
  PlannedFault fault;
  fault.kind = kind;
  return fault;
}

}  // namespace

TEST_CASE("faults: each kind has its own name") {
  const std::set<std::string> words(fault_kind_names().begin(), fault_kind_names().end());
  CHECK(words.size() == static_cast<std::size_t>(kFaultKinds));
  CHECK(fault_kind_names()[static_cast<std::size_t>(FaultKind::kStageStalled)] == "stage_stalled");
  CHECK(fault_kind_names().back() == "scanner_unplugged");
}

TEST_CASE("faults: active from their start time on for their duration, to the nanosecond") {
  PlannedFault leak = planned(FaultKind::kLeak);
  leak.at_s = 2.0;
  leak.lasts_s = 0.5;
  const Faults faults({leak});
  CHECK(faults.any());
  CHECK_FALSE(faults.active(FaultKind::kLeak, 2s - 1ns));
  CHECK(faults.active(FaultKind::kLeak, 2s) == 5.0);
  CHECK(faults.active(FaultKind::kLeak, 2500ms - 1ns));
  CHECK_FALSE(faults.active(FaultKind::kLeak, 2500ms));
  CHECK_FALSE(faults.active(FaultKind::kValveStuck, 2s));
  const Faults at_once({planned(FaultKind::kValveStuck)});
  CHECK(at_once.active(FaultKind::kValveStuck, 0ns) == 0.0);
}

TEST_CASE("faults: default value of each kind, a given value, and an overshoot happens once") {
  CHECK(default_fault_value(FaultKind::kLeak) == 5.0);
  CHECK(default_fault_value(FaultKind::kOvershoot) == 2.0);
  CHECK(default_fault_value(FaultKind::kSupplyLost) == 0.2);
  CHECK(default_fault_value(FaultKind::kFeedbackOffset) == 10.0);
  CHECK(default_fault_value(FaultKind::kReferenceOffset) == 10.0);
  for (const FaultKind none : {FaultKind::kValveStuck, FaultKind::kRegulatorUnpowered, FaultKind::kStageStalled,
                               FaultKind::kRowStuck, FaultKind::kModuleLate})
    CHECK(default_fault_value(none) == 0.0);
  PlannedFault own = planned(FaultKind::kOvershoot);
  own.value = 3.5;
  Faults once({own});
  CHECK(once.take(FaultKind::kOvershoot, 1s) == 3.5);
  CHECK_FALSE(once.take(FaultKind::kOvershoot, 1s));
  own.times = 2;
  Faults twice({own});
  CHECK(twice.take(FaultKind::kOvershoot, 1s));
  CHECK(twice.active(FaultKind::kOvershoot, 1s));  // looking does not count
  CHECK(twice.take(FaultKind::kOvershoot, 1s));
  CHECK_FALSE(twice.active(FaultKind::kOvershoot, 1s));
}

TEST_CASE("faults: start at exactly the given load, at either of two loads, only once") {
  PlannedFault by_psi = planned(FaultKind::kLeak), by_force = planned(FaultKind::kForceStale);
  by_psi.at_psi = 20.0;
  by_psi.lasts_s = 1.0;
  by_force.at_n = 5.0;
  by_force.at_psi = 40.0;
  Faults faults({by_psi, by_force});
  faults.load(19.999, 4.999, 1s);
  CHECK_FALSE(faults.active(FaultKind::kLeak, 1s));
  CHECK_FALSE(faults.active(FaultKind::kForceStale, 1s));
  faults.load(20.0, 0.0, 2s);
  CHECK(faults.active(FaultKind::kLeak, 2s));
  CHECK_FALSE(faults.active(FaultKind::kLeak, 3s));
  faults.load(30.0, 5.0, 4s);
  CHECK_FALSE(faults.active(FaultKind::kLeak, 4s));  // it was once
  CHECK_FALSE(faults.active(FaultKind::kForceStale, 4s - 1ns));
  CHECK(faults.active(FaultKind::kForceStale, 4s));
  Faults other({by_force});
  other.load(40.0, 0.0, 1s);
  CHECK(other.active(FaultKind::kForceStale, 1s));
  // A time and a load: whichever is first.
  by_psi.at_s = 10.0;
  Faults early({by_psi}), late({by_psi});
  early.load(25.0, 0.0, 3s);
  CHECK(early.active(FaultKind::kLeak, 3s));
  CHECK_FALSE(early.active(FaultKind::kLeak, 10s));
  CHECK_FALSE(late.active(FaultKind::kLeak, 9s));
  CHECK(late.active(FaultKind::kLeak, 10s));
  late.load(25.0, 0.0, 10s);
  CHECK_FALSE(late.active(FaultKind::kLeak, 11s));  // its second began at its own time
}

TEST_CASE("faults: clearing ends current faults and keeps later ones, and the newest started one applies") {
  PlannedFault first = planned(FaultKind::kStageStalled), second = first;
  first.at_s = 1.0;
  first.value = 3.0;
  second.at_s = 5.0;
  second.lasts_s = 2.0;
  second.value = 1.0;
  Faults faults({second, first});
  CHECK_FALSE(faults.last(FaultKind::kStageStalled, 1s - 1ns).from);
  CHECK(faults.last(FaultKind::kStageStalled, 1s).from == Nanoseconds(1s));
  CHECK(faults.last(FaultKind::kStageStalled, 1s).value == 3.0);
  CHECK_FALSE(faults.last(FaultKind::kStageStalled, 1s).until);
  CHECK(faults.last(FaultKind::kStageStalled, 5s).value == 1.0);
  CHECK(faults.last(FaultKind::kStageStalled, 5s).until == Nanoseconds(7s));
  faults.clear(FaultKind::kStageStalled, 3s);
  faults.clear(FaultKind::kLeak, 3s);
  CHECK(faults.active(FaultKind::kStageStalled, 3s - 1ns));
  CHECK_FALSE(faults.active(FaultKind::kStageStalled, 3s));
  CHECK(faults.last(FaultKind::kStageStalled, 3s).until == Nanoseconds(3s));
  CHECK(faults.active(FaultKind::kStageStalled, 5s) == 1.0);
  faults.clear(FaultKind::kStageStalled, 7s);  // over by itself: its end stays
  CHECK(faults.last(FaultKind::kStageStalled, 8s).until == Nanoseconds(7s));
  faults.inject(planned(FaultKind::kStageStalled), 9s);
  faults.clear(FaultKind::kStageStalled, 9s);
  CHECK_FALSE(faults.active(FaultKind::kStageStalled, 9s));
  Faults none({});
  CHECK_FALSE(none.any());
  CHECK_FALSE(none.last(FaultKind::kStageStalled, 9s).from);
  CHECK(none.injected(Instrument::kStage, 1s) == InjectedFault::kNone);
}

TEST_CASE("faults: each kind maps to a defect of one instrument") {
  const auto met = [](FaultKind kind, Instrument instrument) {
    Faults faults({planned(kind)});
    return faults.injected(instrument, 1s);
  };
  using I = Instrument;
  using T = InjectedFault;
  using K = FaultKind;
  const std::vector<std::tuple<K, I, T>> table = {{K::kModuleSilent, I::kModule, T::kSilent},
                                                  {K::kModuleLate, I::kModule, T::kLate},
                                                  {K::kModuleCorrupt, I::kModule, T::kCorrupt},
                                                  {K::kModuleStale, I::kModule, T::kStale},
                                                  {K::kModuleException, I::kModule, T::kRefused},
                                                  {K::kModuleBusy, I::kModule, T::kBusy},
                                                  {K::kModuleUnplugged, I::kModule, T::kUnplugged},
                                                  {K::kControllerSilent, I::kController, T::kSilent},
                                                  {K::kControllerLate, I::kController, T::kLate},
                                                  {K::kControllerCorrupt, I::kController, T::kCorrupt},
                                                  {K::kControllerRefused, I::kController, T::kRefused},
                                                  {K::kControllerUnplugged, I::kController, T::kUnplugged},
                                                  {K::kStageSilent, I::kStage, T::kSilent},
                                                  {K::kStageLate, I::kStage, T::kLate},
                                                  {K::kStageCorrupt, I::kStage, T::kCorrupt},
                                                  {K::kStageTorn, I::kStage, T::kTorn},
                                                  {K::kStageUnplugged, I::kStage, T::kUnplugged},
                                                  {K::kForceSaturated, I::kForce, T::kSaturated},
                                                  {K::kForceStale, I::kForce, T::kStale},
                                                  {K::kForceSilent, I::kForce, T::kSilent},
                                                  {K::kScannerSilent, I::kScanner, T::kSilent},
                                                  {K::kScannerStale, I::kScanner, T::kStale},
                                                  {K::kScannerCorrupt, I::kScanner, T::kCorrupt},
                                                  {K::kScannerTorn, I::kScanner, T::kTorn},
                                                  {K::kScannerUnplugged, I::kScanner, T::kUnplugged}};
  for (const auto& [kind, instrument, trouble] : table) {
    INFO(fault_kind_names()[static_cast<std::size_t>(kind)]);
    for (const I asked : {I::kModule, I::kController, I::kStage, I::kForce, I::kScanner})
      CHECK(met(kind, asked) == (asked == instrument ? trouble : T::kNone));
  }
  for (const K other : {K::kLeak, K::kRowStuck, K::kStageStalled}) {
    for (const I asked : {I::kModule, I::kController, I::kStage, I::kForce, I::kScanner})
      CHECK(met(other, asked) == T::kNone);
  }
}

TEST_CASE("fault valve_stuck: the pressure stays, and follows again after the fault is cleared") {
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

TEST_CASE("fault leak: starts at the planned pressure, and the regulator compensates all but an offset") {
  PlannedFault leak = planned(FaultKind::kLeak);
  leak.at_psi = 25.0;
  leak.value = 5.0;
  Bench bench({leak});
  CHECK(bench.hold(20.0) == Approx(20.0).margin(0.2));
  CHECK(bench.hold(30.0) == Approx(30.0 - 2 * 0.75 * 0.12 * 5.0).margin(0.2));
  CHECK(bench.hold(20.0) == Approx(20.0 - 0.9).margin(0.2));  // it stays
}

TEST_CASE("fault overshoot: only the next level overshoots, by the given size, whatever the query times are") {
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

TEST_CASE("fault supply_lost: no higher level is reached, the supply reads 0, venting still works") {
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

TEST_CASE("faults feedback_offset and reference_offset: the two readings disagree") {
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

TEST_CASE("fault row_stuck: the counts of that row are constant, the others keep changing") {
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

}  // namespace tactbench::bench
