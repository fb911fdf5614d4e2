#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "analysis/json_fields.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config_calibration.h"
#include "bench/guard/trip.h"
#include "bench/instruments/check.h"
#include "bench/instruments/scan.h"

namespace tactbench::bench {

namespace {

struct DevicesOptions {
  std::vector<std::string> modbus, set;
  std::string operator_name;
};

BenchConfig bench_of(const DevicesOptions& options, const Session& session) {
  return read_bench(find_config(session.bench_file()), split_overrides(options.set).bench);
}

void scan(const DevicesOptions& options, const Session& session) {
  const std::vector<ScanEntry> entries = scan_devices(options.modbus);
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ScanEntry& entry : entries) {
      list.push_back({JSON_FIELDS(entry, kind, where, what)});
    }
    print_json("devices.scan", {{"devices", list}});
    return;
  }
  analysis::doc::Table table;
  for (const ScanEntry& entry : entries)
    table.rows.push_back({{one_line(entry.kind), one_line(entry.where), one_line(entry.what)}});
  if (!entries.empty()) print_table(std::move(table));
  if (options.modbus.empty()) tty::print("Modbus hosts are queried only when given: --modbus HOST[:PORT]\n");
}

void check(const DevicesOptions& options, Session& session) {
  const BenchConfig config = bench_of(options, session);
  Rig rig(config);
  for (const std::string& place : placeholders_of(config)) tty::print(stderr, "warning: not filled in: {}\n", place);
  const std::vector<DeviceCheck> checks = check_devices(rig, utc_now().substr(0, 10));
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  analysis::doc::Table table;
  for (const DeviceCheck& device : checks) {
    if (device.state == DeviceCheck::State::kAbsent || device.state == DeviceCheck::State::kWrong)
      session.code = ExitCode::kDevice;
    list.push_back({{"role", device.role},
                    {"state", to_string(device.state)},
                    JSON_FIELDS(device, found, reading, notes, remedy)});
    analysis::doc::Phrase text(one_line(device.found, kLongestText));
    const auto add = [&](const std::string& line) {
      if (!line.empty()) text.add("\n" + one_line(line, kLongestText));
    };
    add(device.reading);
    for (const std::string& note : device.notes)
      if (session.all || device.state != DeviceCheck::State::kOk || note.starts_with("WARNING")) add("- " + note);
    add(device.remedy.empty() ? "" : "to do: " + device.remedy);
    table.rows.push_back({{to_string(device.state), one_line(device.role), std::move(text)}});
  }
  if (session.json) return print_json("devices.check", {{"bench", config.id}, {"devices", list}});
  tty::print("bench '{}' ({})\n", config.id, config.file);
  print_table(std::move(table));
  if (!session.all) tty::print("fail-safe layers and certificates: --all\n");
}

// Talks to no instrument: a person has inspected the rig.
void reset(const DevicesOptions& options, const Session& session) {
  check_operator(options.operator_name);
  const BenchConfig config = bench_of(options, session);
  const TripFile file(config.id);
  const std::optional<Trip> trip = file.read();
  if (trip) file.reset(*trip, options.operator_name);
  if (session.json) {
    nlohmann::ordered_json json = {{"bench", config.id}, {"tripped", trip.has_value()}};
    if (trip) json.update({{"utc", trip->utc}, {"id", trip->id}, {"what", trip->what}, {"run", trip->run}});
    print_json("devices.reset", json);
  } else if (trip) {
    tty::print("bench '{}' tripped at {} ({}): {}\nreset by {}; logged in {}\n", config.id, trip->utc, trip->id,
               trip->what, options.operator_name, file.log_path());
  } else {
    tty::print("bench '{}' is not tripped\n", config.id);
  }
}

}  // namespace

void add_devices(CLI::App& app, Session& session) {
  auto options = std::make_shared<DevicesOptions>();
  CLI::App* verb =
      app.add_subcommand("devices", "the bench's instruments: scan, check, test, reset, calibrate-reference");
  verb->require_subcommand(1);
  CLI::App* scan_verb = verb->add_subcommand("scan", "list serial ports, HID devices, NI-DAQmx devices, Modbus hosts");
  scan_verb->add_option("--modbus", options->modbus, "HOST or HOST:PORT to query; may be repeated")->take_all();
  scan_verb->callback([options, &session] { scan(*options, session); });
  CLI::App* check_verb =
      verb->add_subcommand("check",
                           "open each instrument read-only, identify it, read zero\n"
                           "Exit code 3 when one is absent or wrong, 0 with the word warning for one "
                           "that is overdue for calibration.");
  check_verb->callback([options, &session] { check(*options, session); });
  CLI::App* reset_verb = verb->add_subcommand("reset", "show a trip that refuses runs, and remove it");
  reset_verb->add_option("--operator", options->operator_name, "who has inspected the rig; logged")->required();
  reset_verb->callback([options, &session] { reset(*options, session); });
  for (CLI::App* each : {check_verb, reset_verb})
    each->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  add_rig_check(*verb, session);
  add_calibrate_reference(*verb, session);
}

}  // namespace tactbench::bench
