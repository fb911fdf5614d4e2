#include "bench/run/run_record.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/common/build_info.h"
#include "bench/common/utc.h"
#include "bench/run/recorder.h"
#include "bench/run/resume.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

using sequences::Recipe;

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string time_zone() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  return local.tm_zone != nullptr ? local.tm_zone : "UTC";
}

}  // namespace

db::RunRecord program_record() {
  db::RunRecord record;
  record.uuid = db::new_uuid();
  record.state = to_string(RunState::kPrepared);
  record.program_version = build_info().version;
  record.git_commit = build_info().commit;
  record.git_dirty = build_info().modified;
  record.build_id = build_info().build;
  record.host = host_name();
  record.time_zone = time_zone();
  record.started_utc = utc_now();
  return record;
}

db::RunRecord record_of(const RunRequest& request) {
  db::RunRecord record = program_record();
  record.origin = request.bench.origin == devices::Origin::kSimulated ? "simulated" : "hardware";
  record.operator_name = request.operator_name;
  record.purpose = request.purpose;
  record.sensor_serial = request.sensor.serial;
  record.scanner_serial = request.sensor.scanner_serial;
  record.bench_id = request.bench.id;
  record.bench_toml = request.bench.text;
  record.bench_sha256 = db::sha256_hex(request.bench.text);
  record.sensor_toml = request.sensor_type.text;
  record.sensor_sha256 = db::sha256_hex(request.sensor_type.text);
  nlohmann::ordered_json overrides = nlohmann::ordered_json::array();
  for (const auto& item : request.overrides) overrides.push_back({JSON_FIELDS(item, key, value)});
  record.overrides_json = analysis::json_line(overrides);
  if (request.bench.simulation) {
    record.seed = static_cast<std::int64_t>(request.bench.simulation->plant.seed);
    record.sensor_seed = static_cast<std::int64_t>(request.bench.simulation->plant.specimen.sensor_seed);
  }
  for (std::size_t i = 0; i < request.recipes.size(); ++i) {
    const Recipe& recipe = request.recipes[i];
    int frames = 0;
    for (const auto& step : sequences::compile(recipe, static_cast<int>(i))) {
      frames += sequences::has_frame(step) && step.repeat == 0 ? 1 : 0;
    }
    record.sequences.push_back(
        {static_cast<int>(i), recipe.name, recipe.text, db::sha256_hex(recipe.text), recipe.repeats, frames});
  }
  return record;
}

std::optional<std::vector<sequences::Override>> stored_overrides(const std::string& overrides_json) {
  const nlohmann::json list = analysis::try_json(overrides_json);
  if (!list.is_array()) return std::nullopt;
  std::vector<sequences::Override> found;
  for (const auto& item : list) {
    const auto has = [&](const char* name) { return item.contains(name) && item[name].is_string(); };
    if (!has("key") || !has("value")) return std::nullopt;
    found.push_back({item["key"], item["value"]});
  }
  return found;
}

std::optional<BenchConfig> stored_bench(const db::RunRecord& run) {
  std::optional<std::vector<sequences::Override>> overrides = stored_overrides(run.overrides_json);
  if (!overrides) return std::nullopt;
  std::erase_if(*overrides, [](const sequences::Override& item) { return item.key.starts_with("recipe."); });
  try {
    return parse_bench(run.bench_toml, fmt::format("bench file of run {}", run.run), *overrides);
  } catch (const std::exception&) {
    return std::nullopt;  // a profile that it names is gone, or it was written for another version
  }
}

void check_geometry(const RunRequest& request) {
  const devices::ScannerOptions& scanner = request.bench.scanner;
  const bool stated = scanner.frame_source.rows != 0;  // by a frame source itself otherwise
  if (!stated || (request.sensor_type.rows == scanner.rows && request.sensor_type.columns == scanner.columns)) return;
  throw Error("TB-SENSOR-GEOMETRY",
              fmt::format("sensor type '{}' has {} x {} taxels, the bench's scanner {} x {}", request.sensor_type.name,
                          request.sensor_type.rows, request.sensor_type.columns, scanner.rows, scanner.columns),
              request.bench.file + " [scanner], sensor " + request.sensor.serial);
}

void check_same_devices(const db::RunRecord& begun, const std::vector<db::DeviceRecord>& now) {
  for (const db::DeviceRecord& before : begun.devices) {
    const auto same = std::find_if(now.begin(), now.end(), [&](const db::DeviceRecord& device) {
      return device.role == before.role && device.model == before.model && device.serial == before.serial;
    });
    if (same != now.end()) continue;
    throw devices::Fault(
        "TB-RESUME-DEVICES", before.role,
        fmt::format("run {} began with {} '{}', which is not there now", begun.run, before.model, before.serial));
  }
}

void keep_devices(db::RunWriter& store, std::int64_t run, const std::vector<db::DeviceRecord>& devices) {
  const db::RunRecord begun = store.run(run);
  if (!begun.devices.empty()) return check_same_devices(begun, devices);
  try {
    store.set_devices(run, devices);  // a new run, or one that died before it knew its devices
  } catch (const db::StoreError& error) {
    if (error.id() != "TB-STORE-TOO-LONG" && error.id() != "TB-STORE-NOT-TEXT") throw;
    throw devices::Fault("TB-DEVICE-NAME", "instruments", error.what());
  }
}

std::optional<double> rest_of_sensor(const db::RunReader& store, const std::string& sensor_serial, std::int64_t run) {
  std::optional<double> rest;
  for (const db::RunRecord& before : store.runs({.sensor_serial = sensor_serial})) {
    if (before.run >= run || before.sensor_serial != sensor_serial) continue;
    rest = seconds_between(std::max({before.started_utc, before.seen_utc, before.ended_utc}), utc_now());
  }
  return rest;
}

}  // namespace tactbench::bench
