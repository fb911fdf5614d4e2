// Device records of a run: everything that scales their readings, and their stated facts.
#include "bench/rig/device_records.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "devices/stage/zaber_binary.h"

using namespace tactbench;
using namespace tactbench::bench;
using nlohmann::json;

namespace {

const devices::Identity kNamed{"role", "model", "serial", "firmware", devices::Origin::kHardware};

StatedCalibration everything_stated() {
  StatedCalibration stated;
  stated.certificate = "C-1";
  stated.calibrated = "2026-01-31";
  stated.due = "2027-01-31";
  stated.expanded_uncertainty = 0.25;
  stated.covers = "transducer";
  stated.drift = 0.125;
  stated.input_limit = 0.5;
  return stated;
}

// With the keys that end in `unit`; `chain`: data for a budget in addition to U.
json with_stated(json all, const std::string& unit, bool chain, const std::string& input_unit = {}) {
  all.update({{"certificate", "C-1"}, {"calibrated", "2026-01-31"}, {"due", "2027-01-31"}});
  all["expanded_uncertainty_" + unit] = 0.25;
  if (!chain) return all;
  all["certificate_covers"] = "transducer";
  all["drift_" + unit] = 0.125;
  all["input_limit_" + (input_unit.empty() ? unit : input_unit)] = 0.5;
  return all;
}

json with_none(json all) {
  all.update({{"certificate", ""}, {"calibrated", ""}, {"due", ""}});
  return all;
}

json kept(const db::DeviceRecord& record) { return json::parse(record.calibration_json); }

std::string head_of(const db::DeviceRecord& record) {
  return record.role + "|" + record.model + "|" + record.serial + "|" + record.firmware + "|" + record.origin;
}

}  // namespace

TEST_CASE("device records: module and regulator are stored with the scales of their channels") {
  devices::ModuleProfile profile;
  profile.name = "p";
  profile.outputs.channels = 1;
  profile.outputs.volts = {0.0, 32767.0, 0.0, 10.0};
  profile.inputs.channels = 0;
  const auto scale = [](double raw_low, double raw_high, double low, double high) {
    return json{{"raw_low", raw_low}, {"raw_high", raw_high}, {"low", low}, {"high", high}};
  };
  CHECK(head_of(module_record(kNamed, profile)) == "role|model|serial|firmware|hardware");
  CHECK(kept(module_record(kNamed, profile)) == json{{"profile", "p"}, {"output_volts", scale(0, 32767, 0, 10)}});
  profile.outputs.channels = 0;
  profile.inputs.channels = 1;
  profile.inputs.volts = {1.0, 2.0, 3.0, 4.0};
  CHECK(kept(module_record(kNamed, profile)) == json{{"profile", "p"}, {"input_volts", scale(1, 2, 3, 4)}});
  profile.inputs.channels = 0;
  CHECK(kept(module_record(kNamed, profile)) == json{{"profile", "p"}});
  BenchConfig config;
  config.regulator.command_span = {devices::Volts(1.0), devices::Volts(9.0), devices::Psi(2.0), devices::Psi(80.0)};
  devices::Identity simulated = kNamed;
  simulated.origin = devices::Origin::kSimulated;
  CHECK(head_of(regulator_record(simulated, config)).ends_with("|simulated"));
  CHECK(kept(regulator_record(simulated, config)) ==
        json{{"volts_low", 1.0}, {"volts_high", 9.0}, {"psi_low", 2.0}, {"psi_high", 80.0}});
}

TEST_CASE("device records: the reference is stored with correction, limits and stated data, for transducer or gauge") {
  BenchConfig config;
  config.reference.span = {devices::Volts(0.0), devices::Volts(10.0), devices::Psi(0.0), devices::Psi(100.0)};
  const json span = {
      {"volts_low", 0.0}, {"volts_high", 10.0}, {"psi_low", 0.0}, {"psi_high", 100.0}, {"independent", true}};
  CHECK(kept(reference_record(kNamed, config)) == with_none(span));
  config.reference_stated = everything_stated();
  config.reference_limits = {0.01, 0.02, 0.03};
  config.reference_resolution_psi = 0.005;
  const json limits = {
      {"hysteresis_psi", 0.01}, {"zero_psi", 0.02}, {"temperature_psi", 0.03}, {"resolution_psi", 0.005}};
  json all = with_stated(span, "psi", true, "v");
  all.update(limits);
  CHECK(kept(reference_record(kNamed, config)) == all);
  config.reference_independent = false;  // the chain is then the regulator's
  config.reference_gauge.emplace();
  config.reference_gauge->quantity.scale = {0.0, 1000.0, -5.0, 95.0};
  config.reference_correction.reading_psi = {0.0, 50.0};
  config.reference_correction.correction_psi = {0.5, -0.25};
  config.reference_correction.expanded_uncertainty_psi = {0.1, 0.2};
  config.reference_correction.coverage_factor = 2.5;
  all = with_stated({{"raw_low", 0.0}, {"raw_high", 1000.0}, {"low", -5.0}, {"high", 95.0}, {"independent", false}},
                    "psi", false);
  all["correction"] = {{"reading_psi", {0.0, 50.0}},
                       {"correction_psi", {0.5, -0.25}},
                       {"expanded_uncertainty_psi", {0.1, 0.2}},
                       {"coverage_factor", 2.5}};
  all.update(limits);
  CHECK(kept(reference_record(kNamed, config)) == all);
}

TEST_CASE(
    "device records: a thermometer is stored with all stated data, other environment sensors with their scale only") {
  BenchConfig config;
  config.origin = devices::Origin::kHardware;
  EnvironmentSensor sensor;
  sensor.quantity = "temperature_c";
  sensor.model = "T";
  sensor.serial = "7";
  sensor.stated = everything_stated();
  sensor.place.scale = {-1000.0, 1000.0, -100.0, 100.0};
  const json scale = {{"raw_low", -1000.0}, {"raw_high", 1000.0}, {"low", -100.0}, {"high", 100.0}};
  CHECK(head_of(environment_record(sensor, config)) == "temperature_c sensor|T|7||hardware");
  CHECK(kept(environment_record(sensor, config)) == with_stated(scale, "c", true));
  sensor.quantity = "supply_bar";
  CHECK(head_of(environment_record(sensor, config)) == "supply_bar sensor|T|7||hardware");
  CHECK(kept(environment_record(sensor, config)) == scale);
}

TEST_CASE("device records: scanner, force sensor and stage are stored with their settings") {
  BenchConfig config;
  CHECK(kept(scanner_record(kNamed, 0.5, config)) == json{{"volts_per_count", 0.5}});
  config.scanner_cable = "W-1";
  CHECK(kept(scanner_record(kNamed, 0.5, config)) == json{{"volts_per_count", 0.5}, {"cable", "W-1"}});
  ForceConfig force;
  force.records = 20;
  CHECK(kept(force_record({kNamed, "", {}}, force)) == with_none({{"records_per_reading", 20}}));
  force.stated = everything_stated();
  CHECK(kept(force_record({kNamed, "FT-1", {1.0, 2.0, 3.0, 40.0, 50.0, 60.0}}, force)) ==
        with_stated({{"records_per_reading", 20},
                     {"calibration", "FT-1"},
                     {"range_n", {1.0, 2.0, 3.0}},
                     {"range_nmm", {40.0, 50.0, 60.0}}},
                    "n", true));
  StageConfig stage;
  stage.options.axes[1].low = devices::Millimetres(1.5);
  stage.options.axes[1].high = devices::Millimetres(20.5);
  stage.stated = everything_stated();
  CHECK(kept(stage_record(kNamed, 1, stage)) == with_stated({{"low_mm", 1.5}, {"high_mm", 20.5}}, "mm", false));
}

TEST_CASE("device records: instruments are those stated in the bench file, those for pressing only if used") {
  BenchConfig config;
  config.origin = devices::Origin::kSimulated;
  config.reference.model = "R";
  config.reference.serial = "r";
  const auto heads = [&](bool presses) {
    std::string text;
    for (const db::DeviceRecord& record : stated_instruments(config, presses)) text += head_of(record) + "; ";
    return text;
  };
  const std::string reference = "pressure reference|R|r||simulated; ";
  CHECK(heads(true) == reference);
  config.stage.emplace();
  config.stage->options.axes[0].model = "Zaber T-LA60A";
  config.stage->options.axes[0].serial = "X1";
  config.stage->options.axes[1].serial = "Y1";
  config.stage->options.axes[2].model = "Zaber T-NA08A50";
  CHECK(heads(true) == reference +
                           "stage x|Zaber T-LA60A|X1||simulated; stage y||Y1||simulated; "
                           "stage z|Zaber T-NA08A50|||simulated; ");
  config.force.emplace();
  config.force->model = "F";
  config.force->expected_serial = "f";
  CHECK(heads(true).ends_with("|||simulated; force sensor|F|f||simulated; "));
  CHECK(heads(false) == reference);
}
