#include "bench/cli/runs/sensors.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "analysis/counted.h"
#include "analysis/documents/run_json.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report_facts.h"
#include "bench/cli/session.h"
#include "bench/common/terminal.h"
#include "bench/common/utc.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/sensor_state.h"
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

struct SensorsOptions {
  std::string serial, lab;
};

analysis::Laboratory laboratory_of(const SensorsOptions& options) {
  return options.lab.empty() ? analysis::Laboratory() : read_laboratory(find_config(options.lab));
}

std::string last_date(const SensorState& state) {
  return state.runs.empty() ? "never" : analysis::date_of(state.runs.back().started_utc);
}

std::string verdict_cell(const SensorState& state) {
  return state.verdict ? shown_verdict(*state.verdict->verdict, state.runs.back().origin) : "none";
}

bool simulated(const SensorState& state) { return !state.runs.empty() && state.runs.back().origin == "simulated"; }

bool drifted(const SensorState& state) { return state.drift && state.drift->drift.drifted(); }

nlohmann::ordered_json state_json(const db::SensorRecord& sensor, const SensorState& state) {
  nlohmann::ordered_json json = analysis::sensor_json(sensor);
  json["runs"] = nlohmann::ordered_json::array();
  for (const db::RunRecord& run : state.runs) json["runs"].push_back(run.run);
  json["last_utc"] = state.runs.empty() ? "" : state.runs.back().started_utc;
  json["verdict"] = analysis::verdict_text(state.verdict ? state.verdict->verdict : std::nullopt);
  json["judged_run"] = state.judged_run;
  json["valid_until"] = state.valid_until;
  if (!state.drift) return json;
  const analysis::Drift& drift = state.drift->drift;
  json["drift"] = {{"drifted", drift.drifted()},
                   {"since_utc", state.drift->since_utc},
                   {"run", state.drift->run},
                   {"models_of_run", state.drift->model_run},
                   {"advice", analysis::to_string(drift.verdict)},
                   {"as_is_fs", drift.as_is},
                   {"tolerance_fs", drift.tolerance},
                   {"zero_fs", drift.zero},
                   {"zero_expanded_fs", drift.zero_u},
                   {"gain_change", drift.gain},
                   {"gain_expanded", drift.gain_u},
                   {"pattern_fs", drift.adjusted},
                   {"outside_validity", state.drift->outside}};
  return json;
}

// First a sentence per drifted sensor, then one line per sensor.
void print_sensors(const std::vector<std::pair<std::string, SensorState>>& sensors, const Session& session) {
  const auto off = std::ranges::count_if(sensors, [](const auto& sensor) { return drifted(sensor.second); });
  const auto unknown = std::ranges::count_if(sensors, [](const auto& sensor) { return !sensor.second.drift; });
  const bool all_simulated = std::ranges::all_of(sensors, [](const auto& sensor) { return simulated(sensor.second); });
  const bool any_due = std::ranges::any_of(sensors, [](const auto& s) { return !s.second.valid_until.empty(); });
  analysis::doc::Document document;
  document.add(analysis::doc::Paragraph{
      {fmt::format("drifted: {} of {}{}", off, analysis::counted(sensors.size(), "sensor"),
                   unknown > 0 ? fmt::format("; {} without a later run to check models on", unknown) : "")}});
  analysis::doc::Table table{
      .id = {},
      .caption = all_simulated ? "all simulated" : "",
      .columns = {{"sensor"}, {"drifted"}, {"zero, % FS", true}, {"gain, %", true}, {"measured", true}, {"verdict"}}};
  if (any_due) table.columns.push_back({"due", true});
  for (const auto& [serial, state] : sensors) {
    if (drifted(state)) document.add(analysis::doc::Paragraph{{fmt::format("{}: {}", serial, drift_text(state))}});
    const analysis::Drift* drift = state.drift ? &state.drift->drift : nullptr;
    table.rows.push_back(
        {{serial,
          drift == nullptr   ? "–"
          : drift->drifted() ? "YES"
                             : "no",
          drift == nullptr ? "–" : signed_percent(drift->zero, drift->zero_u),
          drift == nullptr || drift->gain_u <= 0.0 ? "–" : signed_percent(drift->gain, drift->gain_u), last_date(state),
          !state.verdict  ? "none"
          : all_simulated ? to_string(*state.verdict->verdict)
                          : verdict_cell(state)}});
    if (any_due) table.rows.back().cells.emplace_back(state.valid_until.empty() ? "–" : one_line(state.valid_until));
  }
  if (!session.quiet) document.add(std::move(table));
  tty::print("{}", to_text(document, session.unit(), line_columns()));
}

void list_sensors(const SensorsOptions& options, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const analysis::Laboratory laboratory = laboratory_of(options);
  WorkProgress progress("sensors", session.quiet || session.json, {{"drift", 1.0, false}});
  auto json = nlohmann::ordered_json::array();
  std::vector<std::pair<std::string, SensorState>> sensors;
  for (const db::SensorRecord& sensor : store.sensors()) {
    sensors.emplace_back(one_line(sensor.serial), sensor_state(store, sensor.serial, laboratory));
    if (session.json) json.push_back(state_json(sensor, sensors.back().second));
  }
  progress.end();
  if (session.json) return print_json("sensors.list", {{"sensors", json}});
  if (sensors.empty()) return tty::print("no sensor is registered: tactbench sensors add SERIAL registers one\n");
  print_sensors(sensors, session);
}

void show_sensor(const SensorsOptions& options, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::optional<db::SensorRecord> sensor = store.sensor(options.serial);
  if (!sensor) {
    throw Error("TB-SENSOR-UNKNOWN", fmt::format("sensor '{}' is not registered", options.serial), session.db,
                "tactbench sensors list shows the registered ones");
  }
  const SensorState state = sensor_state(store, sensor->serial, laboratory_of(options));
  if (session.json) {
    nlohmann::ordered_json json = state_json(*sensor, state);
    json["type_toml"] = sensor->type_toml;
    print_json("sensors.show", json);
    return;
  }
  const auto typed = [](const std::string& text) { return one_line(analysis::doc::stated(text).text, kMaxTextLength); };
  analysis::doc::Table facts = analysis::doc::pairs(
      "sensor " + one_line(sensor->serial),
      {{"drifted", drift_text(state)},
       {"measured", last_date(state)},
       {"verdict", state.verdict ? fmt::format("{} (run {})", verdict_cell(state), state.judged_run) : "none"},
       {"due", typed(state.valid_until)},
       {"type", typed(sensor->type)},
       {"scanner", sensor->scanner_serial.empty() ? "any" : one_line(sensor->scanner_serial)},
       {"note", typed(sensor->note)},
       {"added", analysis::date_of(sensor->added_utc)}});
  if (state.drift)
    for (const std::string& line : state.drift->outside) facts.rows.push_back({{"caution", line}});
  analysis::doc::Table runs{.id = {},
                            .caption = "\nruns",
                            .columns = {{"run", true}, {"started (UTC)"}, {"outcome"}, {"verdict"}, {"purpose"}}};
  for (const db::RunRecord& run : state.runs) {
    const Standing stands = standing(store, run.run);
    runs.rows.push_back(
        {{std::to_string(run.run), run.started_utc, std::string(db::to_string(run.outcome)),
          stands.verdict ? shown_verdict(*stands.verdict, run.origin) : "none", one_line(run.purpose)}});
  }
  analysis::doc::Document document;
  document.add(std::move(facts));
  if (!runs.rows.empty()) document.add(std::move(runs));
  tty::print("{}", to_text(document, session.unit(), line_columns()));
}

}  // namespace

void add_sensors(CLI::App& app, Session& session) {
  CLI::App* sensors = app.add_subcommand("sensors", "register, list or show sensors");
  sensors->require_subcommand(1);
  auto options = std::make_shared<SensorEntry>();
  CLI::App* add_verb = sensors->add_subcommand("add", "register a sensor: its serial, its type file, its scanner");
  add_verb->add_option("serial", options->serial, "the sensor's serial number")->required();
  add_verb->add_option("--type", options->type_file, "sensor type file")->capture_default_str();
  add_verb->add_option("--scanner", options->scanner, "serial number of the scanner that reads it (default: any)");
  add_verb->add_option("--note", options->note, "remarks on the sensor");
  add_verb->callback([options, &session] { add(*options, session); });
  auto asked = std::make_shared<SensorsOptions>();
  const auto add_shared = [asked, &session](CLI::App& verb) {
    session.profile.add(verb, "--lab", ProfileKey::kLab, asked->lab,
                        "laboratory file: until when a calibration is valid");
  };
  CLI::App* list_verb =
      sensors->add_subcommand("list", "one line per sensor: last run, verdict, when it is due, whether it drifted");
  add_shared(*list_verb);
  list_verb->callback([asked, &session] { list_sensors(*asked, session); });
  CLI::App* show_verb = sensors->add_subcommand("show", "one sensor: whether it drifted and how, verdict, runs");
  show_verb->add_option("serial", asked->serial, "the sensor's serial number")->required();
  add_shared(*show_verb);
  show_verb->callback([asked, &session] { show_sensor(*asked, session); });
}

}  // namespace tactbench::bench
