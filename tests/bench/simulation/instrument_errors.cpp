// Errors of the simulated instruments against the rows of the budgets that are to hold them: the truth is the plant's,
// the limits go the whole way from the bench file through the run's record.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/rig/device_records.h"
#include "bench/simulation/plant.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::BenchConfig;
using bench::InstrumentErrors;

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
