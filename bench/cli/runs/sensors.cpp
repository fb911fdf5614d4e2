#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "analysis/json_io.h"
#include "bench/cli/runs/register_sensor.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "db/run_store.h"

namespace tactbench::bench {

db::SensorRecord register_sensor(const std::string& db, const SensorEntry& entry) {
  const SensorType type = read_sensor_type(find_config(entry.type_file));
  db::RunStore store = db::RunStore::open(db);
  db::SensorRecord sensor{entry.serial,  type.name,  type.text, db::sha256_hex(type.text),
                          entry.scanner, entry.note, utc_now()};
  store.add_sensor(sensor);
  return sensor;
}

namespace {

void add(const SensorEntry& entry, const Session& session) {
  const db::SensorRecord sensor = register_sensor(session.db, entry);
  if (session.json) {
    print_json("sensors.add", analysis::sensor_json(sensor));
  } else {
    tty::print("sensor {} ({}) registered in {}\n", one_line(sensor.serial), one_line(sensor.type), session.db);
  }
}

void list_sensors(const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  if (!session.json) tty::print("{:<16}{:<32}{:<18}{}\n", "serial", "type", "scanner", "note");
  for (const db::SensorRecord& sensor : store.sensors()) {
    if (session.json) {
      json.push_back(analysis::sensor_json(sensor));
    } else {
      tty::print("{}{}{}{}\n", cell(sensor.serial, 16), cell(sensor.type, 32),
                 cell(sensor.scanner_serial.empty() ? "any" : sensor.scanner_serial, 18), one_line(sensor.note));
    }
  }
  if (session.json) print_json("sensors.list", {{"sensors", json}});
}

void show_sensor(const std::string& serial, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::optional<db::SensorRecord> sensor = store.sensor(serial);
  if (!sensor) {
    throw Error("TB-SENSOR-UNKNOWN", fmt::format("sensor '{}' is not registered", serial), session.db,
                "tactbench sensors list shows the registered ones");
  }
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (const db::RunRecord& run : store.runs()) {
    if (run.sensor_serial == serial) runs.push_back(run.run);
  }
  if (session.json) {
    nlohmann::ordered_json json = analysis::sensor_json(*sensor);
    json["runs"] = runs;
    json["type_toml"] = sensor->type_toml;
    print_json("sensors.show", json);
    return;
  }
  tty::print("sensor {}\n  type     {}\n  scanner  {}\n  note     {}\n  added    {}\n  runs     {}\n\n{}",
             one_line(sensor->serial), one_line(sensor->type),
             sensor->scanner_serial.empty() ? "any" : one_line(sensor->scanner_serial),
             sensor->note.empty() ? "not stated" : one_line(sensor->note, kLongestText), sensor->added_utc,
             analysis::json_line(runs), sensor->type_toml);
}

}  // namespace

void add_sensors(CLI::App& app, Session& session) {
  CLI::App* sensors = app.add_subcommand("sensors", "register, list or show sensors");
  sensors->require_subcommand(1);
  auto options = std::make_shared<SensorEntry>();
  CLI::App* add_verb = sensors->add_subcommand("add", "register a sensor: its serial, its type file, its scanner");
  add_verb->add_option("serial", options->serial, "the sensor's serial number")->required();
  add_verb->add_option("--type", options->type_file, "sensor type file")->capture_default_str();
  add_verb->add_option("--scanner", options->scanner, "serial of the scanner it is read with (default: any)");
  add_verb->add_option("--note", options->note, "anything worth knowing");
  add_verb->callback([options, &session] { add(*options, session); });
  CLI::App* list_verb = sensors->add_subcommand("list", "one line a sensor");
  list_verb->callback([&session] { list_sensors(session); });
  CLI::App* show_verb = sensors->add_subcommand("show", "one sensor, its type file and its runs");
  show_verb->add_option("serial", options->serial, "the sensor's serial number")->required();
  show_verb->callback([options, &session] { show_sensor(options->serial, session); });
}

}  // namespace tactbench::bench
