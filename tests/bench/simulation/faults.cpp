// The schedule of faults, and what each does to chamber, stage and array. On the wires: simulated_rig_wire.cpp.

#include "bench/simulation/faults.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/rig/device_records.h"
#include "bench/simulation/ephemeral_addresses.h"
#include "bench/simulation/plant.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::BenchConfig;
using bench::InstrumentErrors;
using tactbench::bench::EphemeralAddresses;

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

// Errors of the simulated instruments against the rows of the budgets that are to hold them: the truth is the plant's,
// the limits go the whole way from the bench file through the run's record.

namespace {

constexpr int kBenches = 600;
constexpr const char* kThermometerText =
    "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], span_c = [-100, "
    "100], certificate = 'T', expanded_uncertainty_c = 0.3, drift_c = 0.2}]";

BenchConfig bench_with(Changes changes, int seed) {
  changes.push_back({"simulation.instrument_seed", std::to_string(seed)});
  return simulated_bench(changes);
}

db::RunRecord record_of(const BenchConfig& config) {
  db::RunRecord run;
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {reference_record(
      {"pressure reference", config.reference.model, config.reference.serial, "", config.origin}, config)};
  if (config.force)
    run.devices.push_back(force_record({{"force sensor", "f", "1", "", config.origin}, {}, {}}, *config.force));
  for (const bench::EnvironmentSensor& sensor : config.environment)
    run.devices.push_back(environment_record(sensor, config));
  return run;
}

// Without one limit of the pressure reference's record.
db::RunRecord without(db::RunRecord run, const char* key) {
  auto json = nlohmann::json::parse(run.devices.front().calibration_json);
  REQUIRE(json.erase(key) == 1);
  run.devices.front().calibration_json = json.dump();
  return run;
}

// Error of the reference of one bench, after a rise to or a fall from full pressure.
double error_of(const BenchConfig& config, double pressure_psi, bool up) {
  InstrumentErrors errors(config.simulation->plant.instruments);
  errors.follow(up ? 0.0 : 60.0);
  errors.follow(pressure_psi);
  return errors.reference_psi(pressure_psi, config.simulation->plant.specimen.temperature_c);
}

// Benches that differ in what is drawn for their instruments alone.
std::vector<BenchConfig> benches_with(const Changes& changes) {
  std::vector<BenchConfig> benches(kBenches, bench_with(changes, 1));
  for (int i = 0; i < kBenches; ++i)
    benches[static_cast<std::size_t>(i)].simulation->plant.instruments.seed = static_cast<std::uint64_t>(i) + 1;
  return benches;
}

double share_within(const std::vector<BenchConfig>& benches,
                    const std::function<double(const BenchConfig&)>& expanded) {
  int within = 0, all = 0;
  for (const BenchConfig& config : benches) {
    const double u = expanded(config);
    for (const auto& [psi, up] : {std::pair(2.0, true), std::pair(30.0, true), std::pair(30.0, false)}) {
      within += std::abs(error_of(config, psi, up)) <= u ? 1 : 0;
      ++all;
    }
  }
  return within / static_cast<double>(all);
}

double expanded_of(const BenchConfig& config) {
  return 2.0 * analysis::reference_uncertainty(record_of(config)).combined_u(30.0);
}

}  // namespace

TEST_CASE("instrument errors: a bench without an instrument seed has none") {
  const BenchConfig config = simulated_bench({{"reference.expanded_uncertainty_psi", "0.5"}});
  CHECK(error_of(config, 30.0, true) == 0.0);
  CHECK(InstrumentErrors(config.simulation->plant.instruments).force_n(30.0) == 0.0);
  CHECK(InstrumentErrors(config.simulation->plant.instruments).thermometer_c() == 0.0);
}

TEST_CASE(
    "instrument errors: each limit of the reference chain covers the error drawn for it, and no other limit does") {
  struct Row {
    const char* key;
    Changes changes;
  };
  const Changes chain = {{"reference.certificate_covers", "chain"}};
  const Changes warm = {{"simulation.temperature_c", "29"}};
  const auto with = [](Changes base, const Changes& more) {
    base.insert(base.end(), more.begin(), more.end());
    return base;
  };
  const Row rows[] = {
      {"expanded_uncertainty_psi", with(chain, {{"reference.expanded_uncertainty_psi", "0.2"}})},
      {"drift_psi", with(chain, {{"reference.drift_psi", "0.2"}})},
      {"input_limit_v",
       {{"reference.certificate_covers", "transducer"}, {"reference.input_limit_v", "0.02"}}},  // of 10 psi a volt
      {"hysteresis_psi", with(chain, {{"reference.hysteresis_psi", "0.2"}})},
      {"zero_psi", with(chain, {{"reference.zero_psi", "0.2"}})},
      {"temperature_psi", with(with(chain, {{"reference.temperature_psi", "0.2"}}), warm)}};
  for (const Row& row : rows) {
    CAPTURE(row.key);
    const std::vector<BenchConfig> benches = benches_with(row.changes);
    CHECK(share_within(benches, expanded_of) >= 0.94);
    // A row a third too small, and none at all.
    CHECK(share_within(benches, [](const BenchConfig& config) { return 0.6 * expanded_of(config); }) < 0.85);
    const auto removed = [&](const BenchConfig& config) {
      return 2.0 * analysis::reference_uncertainty(without(record_of(config), row.key)).combined_u(30.0);
    };
    CHECK(share_within(benches, removed) < 0.1);
  }
}

TEST_CASE("instrument errors: U of the whole chain covers about 95 % of the errors drawn for it") {
  const Changes all = {{"reference.certificate_covers", "transducer"},
                       {"reference.expanded_uncertainty_psi", "0.05"},
                       {"reference.drift_psi", "0.03"},
                       {"reference.input_limit_v", "0.01"},
                       {"reference.hysteresis_psi", "0.08"},
                       {"reference.zero_psi", "0.05"},
                       {"reference.temperature_psi", "0.05"},
                       {"simulation.temperature_c", "28"}};
  const std::vector<BenchConfig> benches = benches_with(all);
  const double covered = share_within(benches, expanded_of);
  CHECK(covered > 0.93);
  CHECK(covered < 0.985);
  for (const char* key : {"input_limit_v", "hysteresis_psi"})
    CHECK(share_within(benches, [&](const BenchConfig& config) {
            return 2.0 * analysis::reference_uncertainty(without(record_of(config), key)).combined_u(30.0);
          }) < covered - 0.01);
}

TEST_CASE("instrument errors: U of force sensor and thermometer covers the errors drawn for them") {
  const Changes changes = {{"force.kind", "net"},
                           {"force.certificate", "F"},
                           {"force.expanded_uncertainty_n", "0.2"},
                           {"force.drift_n", "0.1"},
                           {"force.certificate_covers", "transducer"},
                           {"force.input_limit_n", "0.15"},
                           {"environment.sensor", kThermometerText}};
  int force_within = 0, force_half = 0, warm_within = 0, warm_half = 0;
  for (const BenchConfig& config : benches_with(changes)) {
    const db::RunRecord run = record_of(config);
    const auto force = analysis::instrument_uncertainty(run, "force sensor"),
               thermometer = analysis::instrument_uncertainty(run, "temperature_c");
    REQUIRE(force.complete());
    REQUIRE(thermometer.rows.size() == 3);
    CHECK(force.unit == "N");
    CHECK(thermometer.covers == analysis::CertificateCovers::kChain);
    const InstrumentErrors errors(config.simulation->plant.instruments);
    const double error_n = std::abs(errors.force_n(35.0)), error_c = std::abs(errors.thermometer_c());
    force_within += error_n <= force.expanded() ? 1 : 0;
    force_half += error_n <= 0.5 * force.expanded() ? 1 : 0;
    warm_within += error_c <= thermometer.expanded() ? 1 : 0;
    warm_half += error_c <= 0.5 * thermometer.expanded() ? 1 : 0;
  }
  CHECK(force_within >= 0.93 * kBenches);
  CHECK(force_half < 0.8 * kBenches);
  CHECK(warm_within >= 0.93 * kBenches);
  CHECK(warm_half < 0.8 * kBenches);
}

TEST_CASE("instrument errors: readings of reference and thermometer have errors, the true values have none") {
  const Changes changes = {{"reference.expanded_uncertainty_psi", "1"},
                           {"reference.hysteresis_psi", "0.5"},
                           {"simulation.chamber.reference_noise_psi", "0"},
                           {"environment.sensor", kThermometerText}};
  const BenchConfig config = bench_with(changes, 5);
  devices::ManualClock clock;
  bench::Plant plant(config.simulation->plant, clock);
  const double span = config.simulation->plant.chamber.span_psi;
  std::vector<double> errors, expected;
  for (const double psi : {20.0, 40.0, 20.0}) {
    const bool up = plant.true_pressure().value() < psi;
    plant.drive(devices::Volts(psi / span * 10.0), devices::Nanoseconds::max(), devices::Volts(0.0));
    clock.wait_until(clock.now() + std::chrono::seconds(10));
    const double truth = plant.true_pressure().value();
    InstrumentErrors alone(config.simulation->plant.instruments);
    alone.follow(up ? 0.0 : 60.0);
    alone.follow(truth);
    errors.push_back(plant.reference_pressure().value() - truth);
    expected.push_back(alone.reference_psi(truth, 23.0));
    CHECK(errors.back() == Approx(expected.back()).margin(0.15));  // the step's overshoot turns some of the hysteresis
    CHECK(std::abs(errors.back()) > 0.02);
  }
  CHECK(errors[2] - errors[0] > 0.6 * (expected[2] - expected[0]));  // too much falling, too little rising
  CHECK(expected[2] - expected[0] > 0.3);
  CHECK(plant.temperature_c() != 23.0);
  CHECK(std::abs(plant.temperature_c() - 23.0) < 1.0);
}

TEST_CASE("temporary addresses: those of simulated ends are replaced by fixed text, others are unchanged") {
  EphemeralAddresses names;
  names.add("Modbus TCP 127.0.0.1:4000, ADAM-6024");
  names.add("Modbus RTU /dev/pts/3, RS-485");
  names.add("/tmp/tactbench-BIoHmf/scanner");
  names.add("http://127.0.0.1:555/netftapi2.xml");
  CHECK(names.lasting("of 127.0.0.1:4000 unit 1, again 127.0.0.1:4000") ==
        "of 127.0.0.1:PORT unit 1, again 127.0.0.1:PORT");
  CHECK(names.lasting("at 127.0.0.1 port 555 (UDP)") == "at 127.0.0.1 port PORT (UDP)");
  CHECK(names.lasting("packet socket /tmp/tactbench-BIoHmf/scanner: none") == "packet socket SOCKET: none");
  CHECK(names.lasting("/dev/pts/3: none") == "/dev/pts/N: none");
  // Names that only begin like these, and addresses of a real rig.
  for (const char* other : {"127.0.0.1:40001", "/dev/pts/31", "192.168.0.7:4000", "127.0.0.1:502"})
    CHECK(names.lasting(other) == other);
}

TEST_CASE("temporary addresses: how the end of a path, a port and the text is recognised") {
  EphemeralAddresses names;
  names.add("no address");
  CHECK(names.lasting("no address at 127.0.0.1:9") == "no address at 127.0.0.1:9");
  names.add("on /tmp/a,b and more");
  names.add("see 127.0.0.1:40");
  names.add("/dev/pts/12 of a line");
  CHECK(names.lasting("/tmp/a") == "SOCKET");
  CHECK(names.lasting("/tmp/a,b") == "SOCKET,b");
  CHECK(names.lasting("127.0.0.1:401, 127.0.0.1:40") == "127.0.0.1:401, 127.0.0.1:PORT");
  CHECK(names.lasting("127.0.0.1 port 40") == "127.0.0.1 port PORT");
  CHECK(names.lasting("127.0.0.1 port 400") == "127.0.0.1 port 400");
  CHECK(names.lasting("/dev/pts/12/dev/pts/12") == "/dev/pts/N/dev/pts/N");
  CHECK(names.lasting("/dev/pts/123 /dev/pts/12") == "/dev/pts/123 /dev/pts/N");
  CHECK(names.lasting("").empty());
}
