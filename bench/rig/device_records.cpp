#include "bench/rig/device_records.h"

#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"

namespace tactbench::bench {

namespace {

using RecordJson = nlohmann::ordered_json;

RecordJson span_json(const devices::LinearSpan& span) {
  return {{"volts_low", span.volts_low.value()},
          {"volts_high", span.volts_high.value()},
          {"psi_low", span.low.value()},
          {"psi_high", span.high.value()}};
}

RecordJson psi_json(const devices::LinearSpan& span) {  // of what states pressures itself
  return {{"psi_low", span.low.value()}, {"psi_high", span.high.value()}};
}

RecordJson scale_json(const devices::LinearScale& scale) { return {JSON_FIELDS(scale, raw_low, raw_high, low, high)}; }

db::DeviceRecord record_of(const devices::Identity& identity, const RecordJson& calibration) {
  return {identity.role,
          identity.model,
          identity.serial,
          identity.firmware,
          identity.origin == devices::Origin::kSimulated ? "simulated" : "hardware",
          analysis::json_line(calibration)};
}

void add_stated(RecordJson& json, const StatedCalibration& stated, const char* uncertainty_key) {
  json["certificate"] = stated.certificate;
  json["calibrated"] = stated.calibrated;
  json["due"] = stated.due;
  if (stated.expanded_uncertainty > 0.0) json[uncertainty_key] = stated.expanded_uncertainty;
}

void add_chain(RecordJson& json, const StatedCalibration& stated, const char* drift_key, const char* input_key) {
  if (!stated.covers.empty()) json["certificate_covers"] = stated.covers;
  if (stated.drift > 0.0) json[drift_key] = stated.drift;
  if (stated.input_limit > 0.0) json[input_key] = stated.input_limit;
}

}  // namespace

db::DeviceRecord module_record(const devices::Identity& identity, const devices::ModuleProfile& profile) {
  RecordJson json = {{"profile", profile.name}};
  if (profile.outputs.channels > 0) json["output_volts"] = scale_json(profile.outputs.volts);
  if (profile.inputs.channels > 0) json["input_volts"] = scale_json(profile.inputs.volts);
  return record_of(identity, json);
}

db::DeviceRecord regulator_record(const devices::Identity& identity, const BenchConfig& config) {
  const devices::LinearSpan& span = config.regulator.command_span;
  if (config.regulator_kind == RegulatorKind::kModule) return record_of(identity, span_json(span));
  return record_of(identity, psi_json(span));
}

db::DeviceRecord reference_record(const devices::Identity& identity, const BenchConfig& config) {
  const bool states_psi = !config.reference_independent && config.regulator_kind != RegulatorKind::kModule;
  RecordJson json = config.reference_gauge ? scale_json(config.reference_gauge->quantity.scale)
                    : states_psi           ? psi_json(config.reference.span)
                                           : span_json(config.reference.span);
  if (const devices::PressureCorrection& correction = config.reference_correction; !correction.empty()) {
    json["correction"] = {
        JSON_FIELDS(correction, reading_psi, correction_psi, expanded_uncertainty_psi, coverage_factor)};
  }
  json["independent"] = config.reference_independent;
  add_stated(json, config.reference_stated, "expanded_uncertainty_psi");
  if (config.reference_independent) add_chain(json, config.reference_stated, "drift_psi", "input_limit_v");
  const ReferenceLimits& limits = config.reference_limits;
  for (const auto& [key, limit] :
       {std::pair("hysteresis_psi", limits.hysteresis_psi), std::pair("zero_psi", limits.zero_psi),
        std::pair("temperature_psi", limits.temperature_psi)})
    if (limit > 0.0) json[key] = limit;
  if (config.certificate_low_psi < config.certificate_high_psi)
    json["certificate_range_psi"] = {config.certificate_low_psi, config.certificate_high_psi};
  if (config.reference_resolution_psi > 0.0) json["resolution_psi"] = config.reference_resolution_psi;
  return record_of(identity, json);
}

db::DeviceRecord environment_record(const EnvironmentSensor& sensor, const BenchConfig& config) {
  RecordJson json = scale_json(sensor.place.scale);
  if (sensor.quantity == "temperature_c") {
    add_stated(json, sensor.stated, "expanded_uncertainty_c");
    add_chain(json, sensor.stated, "drift_c", "input_limit_c");
  }
  return record_of({sensor.quantity + " sensor", sensor.model, sensor.serial, "", config.origin}, json);
}

db::DeviceRecord scanner_record(const devices::Identity& identity, double volts_per_count, const BenchConfig& config) {
  RecordJson json = {{"volts_per_count", volts_per_count}};
  if (!config.scanner_cable.empty()) json["cable"] = config.scanner_cable;
  return record_of(identity, json);
}

db::DeviceRecord force_record(const ForceIdentity& force, const ForceConfig& config) {
  const auto& range = force.range;
  RecordJson json = {{"records_per_reading", config.records}};
  if (!force.calibration.empty()) {
    json["calibration"] = force.calibration;
    json["range_n"] = {range[0], range[1], range[2]};
    json["range_nmm"] = {range[3], range[4], range[5]};
  }
  add_stated(json, config.stated, "expanded_uncertainty_n");
  add_chain(json, config.stated, "drift_n", "input_limit_n");
  return record_of(force.identity, json);
}

db::DeviceRecord stage_record(const devices::Identity& identity, std::size_t axis, const StageConfig& config) {
  const devices::AxisOptions& option = config.axis(axis);
  RecordJson json = {{"low_mm", option.low.value()}, {"high_mm", option.high.value()}};
  add_stated(json, config.stated, "expanded_uncertainty_mm");
  return record_of(identity, json);
}

std::vector<db::DeviceRecord> stated_instruments(const BenchConfig& config, bool presses) {
  std::vector<db::DeviceRecord> records = {reference_record(
      {"pressure reference", config.reference.model, config.reference.serial, "", config.origin}, config)};
  if (presses && config.stage) {
    for (std::size_t axis = 0; axis < devices::kAxes; ++axis) {
      const devices::AxisOptions& option = config.stage->axis(axis);
      records.push_back(stage_record(
          {std::string("stage ") + "xyz"[axis], option.model, option.serial, "", config.origin}, axis, *config.stage));
    }
  }
  if (presses && config.force) {
    records.push_back(
        force_record({{"force sensor", config.force->model, config.force->expected_serial, "", config.origin}, {}, {}},
                     *config.force));
  }
  return records;
}

}  // namespace tactbench::bench
