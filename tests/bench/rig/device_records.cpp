// What a run keeps of its devices, to the letter: everything that scales their readings, and what is stated of them.
#include "bench/rig/device_records.h"

#include <catch2/catch.hpp>

#include "devices/stage/zaber_binary.h"

using namespace tactbench;
using namespace tactbench::bench;

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

std::string row_of(const db::DeviceRecord& record) {
  return record.role + "|" + record.model + "|" + record.serial + "|" + record.firmware + "|" + record.origin + "|" +
         record.calibration_json;
}

const std::string kAll = R"("certificate":"C-1","calibrated":"2026-01-31","due":"2027-01-31")";
const std::string kNone = R"("certificate":"","calibrated":"","due":"")";

}  // namespace

TEST_CASE("device records: module and regulator with the scales of what they have") {
  devices::ModuleProfile profile;
  profile.name = "p";
  profile.outputs.channels = 1;
  profile.outputs.volts = {0.0, 32767.0, 0.0, 10.0};
  profile.inputs.channels = 0;
  CHECK(
      row_of(module_record(kNamed, profile)) ==
      R"(role|model|serial|firmware|hardware|{"profile":"p","output_volts":{"raw_low":0.0,"raw_high":32767.0,"low":0.0,"high":10.0}})");
  profile.outputs.channels = 0;
  profile.inputs.channels = 1;
  profile.inputs.volts = {1.0, 2.0, 3.0, 4.0};
  CHECK(module_record(kNamed, profile).calibration_json ==
        R"({"profile":"p","input_volts":{"raw_low":1.0,"raw_high":2.0,"low":3.0,"high":4.0}})");
  profile.inputs.channels = 0;
  CHECK(module_record(kNamed, profile).calibration_json == R"({"profile":"p"})");
  BenchConfig config;
  config.regulator.command_span = {devices::Volts(1.0), devices::Volts(9.0), devices::Psi(2.0), devices::Psi(80.0)};
  devices::Identity simulated = kNamed;
  simulated.origin = devices::Origin::kSimulated;
  CHECK(row_of(regulator_record(simulated, config)) ==
        R"(role|model|serial|firmware|simulated|{"volts_low":1.0,"volts_high":9.0,"psi_low":2.0,"psi_high":80.0})");
}

TEST_CASE("device records: the reference by transducer or gauge, with its correction, limits and what is stated") {
  BenchConfig config;
  config.reference.span = {devices::Volts(0.0), devices::Volts(10.0), devices::Psi(0.0), devices::Psi(100.0)};
  const std::string span = R"({"volts_low":0.0,"volts_high":10.0,"psi_low":0.0,"psi_high":100.0,)";
  CHECK(reference_record(kNamed, config).calibration_json == span + R"("independent":true,)" + kNone + "}");
  config.reference_stated = everything_stated();
  config.reference_limits = {0.01, 0.02, 0.03};
  config.reference_resolution_psi = 0.005;
  const std::string stated = kAll + R"(,"expanded_uncertainty_psi":0.25)";
  const std::string limits = R"("hysteresis_psi":0.01,"zero_psi":0.02,"temperature_psi":0.03,"resolution_psi":0.005})";
  CHECK(reference_record(kNamed, config).calibration_json ==
        span + R"("independent":true,)" + stated +
            R"(,"certificate_covers":"transducer","drift_psi":0.125,"input_limit_v":0.5,)" + limits);
  config.reference_independent = false;  // the chain is then the regulator's
  config.reference_gauge.emplace();
  config.reference_gauge->quantity.scale = {0.0, 1000.0, -5.0, 95.0};
  config.reference_correction.reading_psi = {0.0, 50.0};
  config.reference_correction.correction_psi = {0.5, -0.25};
  config.reference_correction.expanded_uncertainty_psi = {0.1, 0.2};
  config.reference_correction.coverage_factor = 2.5;
  CHECK(
      reference_record(kNamed, config).calibration_json ==
      R"({"raw_low":0.0,"raw_high":1000.0,"low":-5.0,"high":95.0,"correction":{"reading_psi":[0.0,50.0],)"
      R"("correction_psi":[0.5,-0.25],"expanded_uncertainty_psi":[0.1,0.2],"coverage_factor":2.5},"independent":false,)" +
          stated + "," + limits);
}

TEST_CASE("device records: a thermometer with all that is stated of it, other surroundings with their scale alone") {
  BenchConfig config;
  config.origin = devices::Origin::kHardware;
  EnvironmentSensor sensor;
  sensor.quantity = "temperature_c";
  sensor.model = "T";
  sensor.serial = "7";
  sensor.stated = everything_stated();
  sensor.place.scale = {-1000.0, 1000.0, -100.0, 100.0};
  const std::string scale = R"({"raw_low":-1000.0,"raw_high":1000.0,"low":-100.0,"high":100.0)";
  CHECK(row_of(environment_record(sensor, config)) ==
        "temperature_c sensor|T|7||hardware|" + scale + "," + kAll +
            R"(,"expanded_uncertainty_c":0.25,"certificate_covers":"transducer","drift_c":0.125,"input_limit_c":0.5})");
  sensor.quantity = "supply_bar";
  CHECK(row_of(environment_record(sensor, config)) == "supply_bar sensor|T|7||hardware|" + scale + "}");
}

TEST_CASE("device records: scanner, force sensor and stage") {
  BenchConfig config;
  CHECK(scanner_record(kNamed, 0.5, config).calibration_json == R"({"volts_per_count":0.5})");
  config.scanner_cable = "W-1";
  CHECK(scanner_record(kNamed, 0.5, config).calibration_json == R"({"volts_per_count":0.5,"cable":"W-1"})");
  ForceConfig force;
  force.records = 20;
  CHECK(force_record({kNamed, "", {}}, force).calibration_json == R"({"records_per_reading":20,)" + kNone + "}");
  force.stated = everything_stated();
  CHECK(force_record({kNamed, "FT-1", {1.0, 2.0, 3.0, 40.0, 50.0, 60.0}}, force).calibration_json ==
        R"({"records_per_reading":20,"calibration":"FT-1","range_n":[1.0,2.0,3.0],"range_nmm":[40.0,50.0,60.0],)" +
            kAll +
            R"(,"expanded_uncertainty_n":0.25,"certificate_covers":"transducer","drift_n":0.125,"input_limit_n":0.5})");
  StageConfig stage;
  stage.options.axes[1].low = devices::Millimetres(1.5);
  stage.options.axes[1].high = devices::Millimetres(20.5);
  stage.stated = everything_stated();
  CHECK(stage_record(kNamed, 1, stage).calibration_json ==
        R"({"low_mm":1.5,"high_mm":20.5,)" + kAll + R"(,"expanded_uncertainty_mm":0.25})");
}

TEST_CASE("device records: the instruments that a bench file states, with those that press where they are used") {
  BenchConfig config;
  config.origin = devices::Origin::kSimulated;
  config.reference.model = "R";
  config.reference.serial = "r";
  const auto heads = [&](bool presses) {
    std::string text;
    for (const db::DeviceRecord& record : stated_instruments(config, presses))
      text +=
          record.role + "|" + record.model + "|" + record.serial + "|" + record.firmware + "|" + record.origin + "; ";
    return text;
  };
  const std::string reference = "pressure reference|R|r||simulated; ";
  CHECK(heads(true) == reference);
  config.stage.emplace();
  config.stage->options.axes[0].device_id = 60;
  config.stage->options.axes[0].serial = "X1";
  config.stage->options.axes[1].device_id = 1;  // no known model
  config.stage->options.axes[1].serial = "Y1";
  config.stage->options.axes[2].device_id = 5082;
  CHECK(heads(true) == reference +
                           "stage x|Zaber T-LA60A|X1||simulated; stage y||Y1||simulated; "
                           "stage z|Zaber T-NA08A50|||simulated; ");
  config.force.emplace();
  config.force->model = "F";
  config.force->serial = "f";
  CHECK(heads(true).ends_with("|||simulated; force sensor|F|f||simulated; "));
  CHECK(heads(false) == reference);
}
