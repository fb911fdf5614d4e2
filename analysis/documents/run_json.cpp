#include "analysis/documents/run_json.h"

#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

using RunJson = nlohmann::ordered_json;

RunJson recipe_json(const db::SequenceRecord& sequence) {
  return {
      {"name", sequence.name}, {"sha256", sequence.recipe_sha256}, JSON_FIELDS(sequence, repeats, frames_per_repeat)};
}

RunJson device_json(const db::DeviceRecord& device, const std::string& started_utc,
                    std::span<const InstrumentNote> notes) {
  const InstrumentCalibration calibration = calibration_of(device, notes);
  return {{"role", device.role},
          JSON_FIELDS(calibration, model, serial),
          JSON_FIELDS(device, firmware, origin),
          JSON_FIELDS(calibration, certificate, calibrated_by),
          {"calibrated", calibration.calibrated_on},
          {"due", calibration.due},
          {"overdue", due_state(calibration, started_utc) == DueState::kOverdue},
          {"uncertainty", calibration.stated_u ? display_text(*calibration.stated_u, PressureUnit::kPsi) : ""},
          {"remarks", calibration.remarks}};
}

}  // namespace

RunJson run_json(const db::RunRecord& run, std::span<const InstrumentNote> notes) {
  RunJson recipes = RunJson::array(), devices = RunJson::array();
  for (const db::SequenceRecord& sequence : run.sequences) recipes.push_back(recipe_json(sequence));
  for (const db::DeviceRecord& device : run.devices) devices.push_back(device_json(device, run.started_utc, notes));
  return {JSON_FIELDS(run, run, uuid, origin, state),
          {"outcome", db::to_string(run.outcome)},
          {"reason", run.reason},
          {"safe_state", db::to_string(run.safe_state)},
          {"operator", run.operator_name},
          {"purpose", run.purpose},
          {"sensor", run.sensor_serial},
          {"sensor_type_sha256", run.sensor_sha256},
          {"scanner", scanner_serial_of(run)},
          {"bench", run.bench_id},
          {"bench_sha256", run.bench_sha256},
          {"overrides", ordered_json_or_null(run.overrides_json)},
          JSON_FIELDS(run, seed, sensor_seed, started_utc, ended_utc),
          {"rest_s", run.rest_s ? RunJson(*run.rest_s) : RunJson()},
          JSON_FIELDS(run, host, time_zone, program_version, git_commit, git_dirty, build_id, content_sha256, tags),
          {"metadata", RunJson(metadata_of(run))},
          {"notes", run.notes},
          {"void", run.is_void()},
          JSON_FIELDS(run, void_reason, void_by, void_utc),
          {"recipes", recipes},
          {"devices", devices}};
}

RunJson sensor_json(const db::SensorRecord& sensor) {
  return {JSON_FIELDS(sensor, serial, type, type_sha256),
          {"scanner", sensor.scanner_serial},
          JSON_FIELDS(sensor, note, added_utc)};
}

std::map<std::string, std::string> metadata_of(const db::RunRecord& run) {
  std::map<std::string, std::string> metadata;
  for (const std::string& tag : run.tags)
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)
      metadata[tag.substr(0, equals)] = tag.substr(equals + 1);
  return metadata;
}

nlohmann::ordered_json evaluation_json(const Evaluation& evaluation) {
  const Evaluation& e = evaluation;
  nlohmann::ordered_json made_worse = nlohmann::ordered_json::array();
  for (const LevelFigures& level : e.levels)
    if (level.made_worse) made_worse.push_back(level.pressure_psi);
  return {JSON_FIELDS(e, frames, full_scale_v, full_scale_psi, hysteresis_max_fs, hysteresis_mean_fs, mean_error_psi,
                      max_error_psi, mean_error_observable_psi, max_error_observable_psi, worst_taxel_mean_error_psi,
                      worst_taxel),
          {"raw_distance_fs", e.raw_distance},
          {"comp_distance_of_mean_fs", e.comp_distance_of_mean},
          {"comp_distance_fs", e.comp_distance},
          {"comp_distance_observable_fs", e.comp_distance_observable},
          {"worst_taxel_distance_fs", e.worst_taxel_distance},
          {"worst_taxel_distance_observable_fs", e.worst_taxel_distance_observable},
          {"flat_share", e.flat_share},
          {"levels_made_worse_psi", made_worse}};
}

}  // namespace tactbench::analysis
