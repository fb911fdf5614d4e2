#include "bench/config/config_pressure.h"

#include <fmt/format.h>

#include <filesystem>

#include "bench/common/process_time.h"
#include "bench/config/config_calibration.h"
#include "bench/config/config_modbus.h"
#include "bench/config/config_profile.h"

namespace tactbench::bench {

using devices::Psi;
using devices::Volts;
using sequences::TomlTable;

namespace {

bool has_own_line(const TomlTable& table) { return table.has("host") || table.has("port") || table.has("serial_port"); }

// Of a line of its own, or another unit on the module's.
devices::ModbusEndpoint endpoint_or_unit(const TomlTable& table, const BenchConfig& config) {
  if (has_own_line(table)) return read_endpoint(table, config.in_process, std::chrono::seconds(1));
  devices::ModbusEndpoint endpoint = config.module.endpoint;
  endpoint.unit = static_cast<int>(table.integer("unit", 1, 247));
  return endpoint;
}

void read_channels(const TomlTable& table, devices::ModuleProfile& profile) {
  if (profile.outputs.channels > 0) {
    profile.outputs.channels = static_cast<int>(table.integer("outputs", profile.outputs.channels, 1, 64));
  }
  if (profile.inputs.channels > 0) {
    profile.inputs.channels = static_cast<int>(table.integer("inputs", profile.inputs.channels, 1, 60));
  }
}

void check_transport(const TomlTable& table, const ModuleConfig& module) {
  const bool rtu = !module.endpoint.serial_port.empty();
  if (rtu ? module.profile.rtu : module.profile.tcp) return;
  table.fail("profile", fmt::format("'{}' does not support Modbus {}", module.profile.name, rtu ? "RTU" : "TCP"),
             rtu ? "set transport = \"tcp\", or choose another profile" : "set transport = \"rtu\" and serial_port");
}

ModuleConfig read_module(const TomlTable& table, const BenchConfig& config) {
  ModuleConfig module;
  module.profile = read_module_profile(table.text("profile"));
  read_channels(table, module.profile);
  module.endpoint = read_endpoint(table, config.in_process, module.profile.max_reply_delay);
  check_transport(table, module);
  return module;
}

void read_modules(const TomlTable& root, BenchConfig& config) {
  const TomlTable table = root.table("module");
  config.module = read_module(table, config);
  if (config.module.profile.outputs.channels == 0) {
    table.fail("profile", fmt::format("'{}' has no outputs to drive the regulator", config.module.profile.name),
               "name the output module here and this one in [input_module]");
  }
  if (config.module.profile.fail_safe.watchdog_address >= 0) {
    config.watchdog_s = table.number_in("watchdog_ms", 1000, 500, 60000) / 1000.0;
  } else if (table.has("watchdog_ms")) {
    table.fail("watchdog_ms", fmt::format("'{}' has no watchdog that can be set", config.module.profile.name),
               "omit it; `tactbench plan` and `devices check` print the fail-safe layers");
  } else {
    config.watchdog_s = 0.0;
  }
  config.module.profile.dump_coil = static_cast<int>(table.integer("dump_coil", -1, -1, 65535));
  table.finish();
  if (root.has("input_module")) {
    const TomlTable inputs = root.table("input_module");
    if (has_own_line(inputs)) {
      config.input_module = read_module(inputs, config);
    } else {
      config.input_module = ModuleConfig{read_module_profile(inputs.text("profile")), config.module.endpoint, true};
      config.input_module->endpoint.unit = static_cast<int>(inputs.integer("unit", 0, 247));
      read_channels(inputs, config.input_module->profile);
      check_transport(inputs, *config.input_module);
    }
    if (config.input_module->profile.inputs.channels == 0) {
      inputs.fail("profile", fmt::format("'{}' has no inputs", config.input_module->profile.name),
                  "name the module that reads feedback and reference");
    }
    inputs.finish();
  } else if (config.module.profile.inputs.channels == 0) {
    root.fail("module", fmt::format("'{}' has no inputs to read the regulator's feedback", config.module.profile.name),
              "add [input_module] with the profile of the module that has them");
  }
}

devices::LinearSpan read_span(const TomlTable& table, const std::string& volts_key, const std::string& pressure_key,
                              double psi_per_unit, std::pair<double, double> pressure_default) {
  const auto volts = table.span(volts_key, {0.0, 10.0});
  const auto pressure = table.span(pressure_key, pressure_default);
  return {Volts(volts.first), Volts(volts.second), Psi(pressure.first * psi_per_unit),
          Psi(pressure.second * psi_per_unit)};
}

void read_regulator(const TomlTable& table, BenchConfig& config) {
  devices::RegulatorOptions& regulator = config.regulator;
  regulator.model = table.text("model", regulator.model);
  regulator.serial = table.text("serial");
  regulator.output_channel = static_cast<int>(table.integer("output_channel", 0, 0, 63));
  regulator.feedback_channel = static_cast<int>(table.integer("feedback_channel", 0, 0, 63));
  regulator.command_span = read_span(table, "span_v", "span_bar", devices::kPsiPerBar, {0.0, 9.0});
  regulator.feedback_span = regulator.command_span;
  const double feed_ms = table.number_in("feed_interval_ms", 450, 50, 500);
  if (config.watchdog_s > 0.0 && feed_ms / 1000.0 > 0.6 * config.watchdog_s) {
    table.fail(
        "feed_interval_ms",
        fmt::format("feeding every {:g} ms is too slow for a watchdog of {:g} ms", feed_ms, 1000.0 * config.watchdog_s),
        "keep it at or below 0.6 of [module] watchdog_ms");
  }
  regulator.feed_interval = seconds(feed_ms / 1000.0);
  regulator.command_limit = Psi(config.limits.command_psi);
  regulator.origin = config.origin;
  table.finish();
}

devices::PressureCorrection read_correction(const TomlTable& table, bool own_file = false) {
  devices::PressureCorrection correction;
  if (own_file) (void)table.integer("schema", 1, 1);
  correction.reading_psi = table.numbers("reading_psi");
  correction.correction_psi = table.numbers("correction_psi");
  correction.expanded_uncertainty_psi = table.numbers("expanded_uncertainty_psi");
  correction.coverage_factor = table.number_in("coverage_factor", 2.0, 1.0, 4.0);
  const std::size_t points = correction.reading_psi.size();
  for (std::size_t i = 1; i < points; ++i) {
    if (correction.reading_psi[i] <= correction.reading_psi[i - 1]) {
      table.fail("reading_psi", "the readings do not rise", "write them from the lowest to the highest");
    }
  }
  if (points == 0 || correction.correction_psi.size() != points ||
      correction.expanded_uncertainty_psi.size() != points) {
    table.fail("reading_psi", "reading_psi, correction_psi and expanded_uncertainty_psi differ in length, or are empty",
               "write one correction and one uncertainty for each reading of the certificate");
  }
  table.finish();
  return correction;
}

void read_gauge(const TomlTable& table, BenchConfig& config) {
  GaugeConfig gauge;
  gauge.own_line = has_own_line(table);
  gauge.endpoint = endpoint_or_unit(table, config);
  gauge.quantity = read_quantity_place(table, "span_psi");
  table.finish();
  config.reference_gauge = gauge;
}

void read_reference(const TomlTable& table, BenchConfig& config) {
  config.reference_independent = table.boolean("independent", true);
  config.reference_stated = read_stated_calibration(table, "expanded_uncertainty_psi", 10.0);
  read_chain(table, config.origin, "drift_psi", "input_limit_v", 10.0, config.reference_stated);
  ReferenceLimits& limits = config.reference_limits;
  limits.hysteresis_psi = table.number_in("hysteresis_psi", 0.0, 0.0, 10.0);
  limits.zero_psi = table.number_in("zero_psi", 0.0, 0.0, 10.0);
  limits.temperature_psi = table.number_in("temperature_psi", 0.0, 0.0, 10.0);
  config.reference_resolution_psi = table.number_in("resolution_psi", 0.0, 0.0, 10.0);
  devices::TransducerOptions& reference = config.reference;
  reference.origin = config.origin;
  if (config.reference_independent) {
    reference.model = table.text("model");
    reference.serial = table.text("serial");
  }
  if (table.has("gauge")) {
    if (!config.reference_independent) {
      table.fail("independent", "a gauge is an independent reference", "set independent = true, or remove the gauge");
    }
    for (const char* key : {"channel", "span_v", "span_psi", "input_limit_v"}) {
      if (table.has(key))
        table.fail(key, "a gauge reads pressure directly", fmt::format("remove '{}' or the gauge", key));
    }
    // "transducer" would have asked for input_limit_v.
    config.reference_stated.covers = "chain";
    read_gauge(table.table("gauge"), config);
  } else if (config.reference_independent) {
    reference.channel = static_cast<int>(table.integer("channel", 1, 0, 63));
    if (reference.channel == config.regulator.feedback_channel) {
      table.fail("channel", "the reference shares the regulator's feedback channel",
                 "wire the transducer to an input of its own, or set independent = false");
    }
    reference.span = read_span(table, "span_v", "span_psi", 1.0, {0.0, 100.0});
  } else {  // the regulator's own monitor output serves as reference
    reference.model = config.regulator.model + " (feedback)";
    reference.serial = config.regulator.serial;
    reference.channel = config.regulator.feedback_channel;
    reference.span = config.regulator.feedback_span;
  }
  if (table.has("correction")) config.reference_correction = read_correction(table.table("correction"));
  if (table.has("correction_file")) {
    if (table.has("correction")) {
      table.fail("correction_file", "the correction is given twice", "keep [reference.correction] or correction_file");
    }
    // Beside the bench file, as its other relative names.
    const auto path = std::filesystem::path(config.file).parent_path() / table.text("correction_file");
    const auto document = sequences::TomlDocument::from_file(path.string());
    config.reference_correction = read_correction(document.root(), true);
  }
  table.finish();
}

EnvironmentSensor read_sensor(const TomlTable& table, const BenchConfig& config) {
  EnvironmentSensor sensor;
  sensor.quantity = table.word("quantity", {"temperature_c", "supply_bar"});
  sensor.model = table.text("model", "not stated");
  sensor.serial = table.text("serial", "not stated");
  sensor.own_line = has_own_line(table);
  sensor.endpoint = endpoint_or_unit(table, config);
  sensor.place = read_quantity_place(table, sensor.quantity == "temperature_c" ? "span_c" : "span_bar");
  if (sensor.quantity == "temperature_c") {
    sensor.stated = read_stated_calibration(table, "expanded_uncertainty_c", 10.0);
    read_chain(table, config.origin, "drift_c", "input_limit_c", 10.0, sensor.stated);
  }
  table.finish();
  return sensor;
}

}  // namespace

void read_pressure(const TomlTable& root, BenchConfig& config) {
  read_modules(root, config);
  read_regulator(root.table("regulator"), config);
  read_reference(root.table("reference"), config);
  const TomlTable environment = root.table("environment");
  for (const TomlTable& sensor : environment.tables("sensor")) {
    config.environment.push_back(read_sensor(sensor, config));
  }
  environment.finish();
}

}  // namespace tactbench::bench
