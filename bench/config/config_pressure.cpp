#include "bench/config/config_pressure.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "analysis/pressure_unit.h"
#include "bench/common/process_time.h"
#include "bench/config/config_calibration.h"
#include "bench/config/config_modbus.h"
#include "bench/config/config_profile.h"
#include "bench/config/instrument_kinds.h"

namespace tactbench::bench {

using devices::Psi;
using devices::Volts;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

bool has_own_line(const TomlTable& table) { return table.has("host") || table.has("port") || table.has("serial_port"); }

// The endpoint on a separate line, or another unit on the module's line.
devices::ModbusEndpoint endpoint_or_unit(const TomlTable& table, const BenchConfig& config) {
  if (has_own_line(table)) return read_endpoint(table, config.in_process, std::chrono::seconds(1));
  if (!config.module.present()) {
    table.fail("unit", "the bench has no [module] whose line it could share", "give it its own host or serial_port");
  }
  devices::ModbusEndpoint endpoint = config.module.endpoint;
  read_keys(table, unit_keys(endpoint, 1));
  return endpoint;
}

KeyTable profile_keys(std::string& profile, const char* meaning) {
  return {key::required(key::text("profile", profile, meaning))};
}
constexpr const char* kOfModule =
    "Analog module that drives the regulator or, with a serial regulator, reads the transducer: name of a shipped "
    "profile, or your own file";
constexpr const char* kOfInputModule =
    "Module that reads feedback and reference, if the first has no inputs: name of a shipped profile, or a file";

std::string profile_of(const TomlTable& table, const char* meaning) {
  std::string profile;
  read_keys(table, profile_keys(profile, meaning));
  return profile;
}

KeyTable output_keys(devices::ModuleProfile& profile) {
  return {
      key::described(key::number("outputs", profile.outputs.channels, kOne, {1, 64},
                                 "Number of output words in the module's process image, as its terminals make them"),
                     "the profile's")};
}

KeyTable input_keys(devices::ModuleProfile& profile) {
  return {key::described(key::number("inputs", profile.inputs.channels, kOne, {1, 60},
                                     "Number of input words in the module's process image"),
                         "the profile's")};
}

void read_channels(const TomlTable& table, devices::ModuleProfile& profile) {
  if (profile.outputs.channels > 0) read_keys(table, output_keys(profile));
  if (profile.inputs.channels > 0) read_keys(table, input_keys(profile));
}

KeyTable watchdog_keys(BenchConfig& config) {
  config.watchdog_s = 1.0;  // where the module has one
  return {key::number("watchdog_ms", config.watchdog_s, kMilliseconds, {500.0, 60000.0, true},
                      "The module sets its outputs to 0 V when it is not written to for this long; 0 or omitted for a "
                      "module whose profile has no watchdog")};
}

KeyTable dump_keys(devices::ModuleProfile& profile) {
  return {key::number("dump_coil", profile.dump_coil, kOne, {-1, 65535},
                      "Number of the digital output that holds a dump valve closed (without power it opens); -1: no "
                      "such valve")};
}

void check_transport(const TomlTable& table, const ModuleConfig& module) {
  const bool rtu = !module.endpoint.serial_port.empty();
  if (rtu ? module.profile.rtu : module.profile.tcp) return;
  table.fail("profile", fmt::format("'{}' does not support Modbus {}", module.profile.name, rtu ? "RTU" : "TCP"),
             rtu ? "set transport = \"tcp\", or choose another profile" : "set transport = \"rtu\" and serial_port");
}

ModuleConfig read_module(const TomlTable& table, const BenchConfig& config, const char* meaning) {
  ModuleConfig module;
  module.profile = read_module_profile(profile_of(table, meaning));
  read_channels(table, module.profile);
  module.endpoint = read_endpoint(table, config.in_process, module.profile.max_reply_delay);
  check_transport(table, module);
  return module;
}

// With a regulator that needs no module, a module may read the transducer.
void read_reading_module(const TomlTable& root, BenchConfig& config) {
  if (root.has("input_module")) {
    root.fail("input_module", "a serial regulator has no output module, so there is no separate input module",
              "name the module that reads the transducer in [module]");
  }
  if (!root.has("module")) return;
  const TomlTable table = root.table("module");
  config.module = read_module(table, config, kOfModule);
  if (config.module.profile.inputs.channels == 0) {
    table.fail("profile", fmt::format("'{}' has no inputs", config.module.profile.name),
               "name the module that reads the transducer, or remove [module]");
  }
  table.finish();
}

void read_modules(const TomlTable& root, BenchConfig& config) {
  const TomlTable table = root.table("module");
  config.module = read_module(table, config, kOfModule);
  if (config.module.profile.outputs.channels == 0) {
    table.fail("profile", fmt::format("'{}' has no outputs to drive the regulator", config.module.profile.name),
               "name the output module here and this one in [input_module]");
  }
  const bool has_watchdog = config.module.profile.fail_safe.watchdog_address >= 0;
  if (has_watchdog || table.has("watchdog_ms")) read_keys(table, watchdog_keys(config));
  if (!table.has("watchdog_ms") && !has_watchdog) config.watchdog_s = 0.0;
  if (has_watchdog != (config.watchdog_s > 0.0)) {
    table.fail("watchdog_ms",
               has_watchdog ? "0 would leave the module without its watchdog"
                            : fmt::format("'{}' has no watchdog that can be set", config.module.profile.name),
               has_watchdog ? "give it 500 ms or more"
                            : "omit it; `tactbench plan` and `devices check` print the fail-safe layers");
  }
  if (has_watchdog) {  // a feeding begins by 0.6 of its time, so a module that was busy is still fed in time
    config.module.endpoint.busy_time = std::min(config.module.endpoint.busy_time, seconds(0.4 * config.watchdog_s));
  }
  read_whole(table, dump_keys(config.module.profile));
  if (root.has("input_module")) {
    const TomlTable inputs = root.table("input_module");
    if (has_own_line(inputs)) {
      config.input_module = read_module(inputs, config, kOfInputModule);
    } else {
      config.input_module =
          ModuleConfig{read_module_profile(profile_of(inputs, kOfInputModule)), config.module.endpoint, true};
      read_keys(inputs, unit_keys(config.input_module->endpoint, 0));
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

KeyTable named_keys(devices::RegulatorOptions& regulator) {
  regulator.feed_interval = std::chrono::milliseconds(450);
  return {key::text("model", regulator.model, "Maker and model, stored with each run"),
          key::required(key::text("serial", regulator.serial, "Serial number, stored with each run")),
          key::optional(key::text(
              "relief", regulator.relief,
              "Device that relieves the chamber if the regulator may not, e.g. \"relief valve, 5 psi\"; required for a "
              "regulator that 0 V does not vent, and for a serial one, which keeps its set-point if the line fails")),
          key::number("feed_interval_ms", regulator.feed_interval, kMilliseconds, {50.0, 500.0},
                      "The set-point is written again and read back this often; at most 0.6 of the module's "
                      "watchdog_ms")};
}

KeyTable module_regulator_keys(devices::RegulatorOptions& regulator) {
  regulator.command_span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(9.0 * devices::kPsiPerBar)};
  devices::LinearSpan& span = regulator.command_span;
  return {
      key::number("output_channel", regulator.output_channel, kOne, {0, 63},
                  "Output of the module that carries the set-point, counted from 0"),
      key::number("feedback_channel", regulator.feedback_channel, kOne, {0, 63},
                  "Input of the module that carries the regulator's monitor voltage, counted from 0"),
      key::span("span_v", span.volts_low, span.volts_high, {"V"},
                "Lowest and highest voltage of set-point and monitor ..."),
      key::span("span_bar", span.low, span.high, {"bar", devices::kPsiPerBar}, "... and the corresponding pressures")};
}

KeyTable serial_regulator_keys(BenchConfig& config) {
  devices::SerialControllerOptions& controller = config.controller;
  devices::SerialAddress& line = config.controller_address;
  line.baud = 19200;
  config.regulator.command_span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(100.0)};  // of the simulated plant
  return {key::text("port", line.port, "Serial: its line, a device, preferably a name in /dev/serial/by-id"),
          key::text("usb_serial", line.usb_serial,
                    "Serial: serial number of the USB adapter; finds the line instead of port, or checks it"),
          key::number("baud", line.baud, {"bit/s"}, {2400, 921600}, "Serial: speed of the line"),
          key::word("unit", controller.unit, {"A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "K", "L", "M",
                                              "N", "O", "P", "Q", "R", "S", "T", "U", "V", "W", "X", "Y", "Z"},
                    "Serial: letter of the controller on its line"),
          key::number("full_scale_psi", config.regulator.command_span.high, {"psi"}, {1.0, 600.0},
                      "Serial: highest set-point of the controller, which must be set to psi gauge"),
          key::number("decimals", controller.decimals, kOne, {0, 2},
                      "Serial: decimals of its set-point, as its display shows them"),
          key::number("pressure_field", controller.pressure_field, kOne, {1, 16},
                      "Serial: place of the pressure in its answer, counted from 1 after the letter"),
          key::number("setpoint_field", controller.setpoint_field, kOne, {1, 16},
                      "Serial: place of the set-point in its answer"),
          key::flag("exhaust", controller.exhausts, "Serial: it has an exhaust valve, which every vent then opens"),
          key::number("reply_timeout_ms", controller.reply_timeout, kMilliseconds, {20.0, 5000.0},
                      "Serial: longest time to wait for an answer")};
}

// A bench that cannot be vented, or that the module's own fallback to 0 V would load.
void check_zero_volt(const TomlTable& table, BenchConfig& config) {
  devices::RegulatorOptions& regulator = config.regulator;
  const devices::LinearSpan& span = regulator.command_span;
  const devices::LinearScale& output = config.module.profile.outputs.volts;
  if (!zero_volt_vents(config) && regulator.relief.empty()) {
    table.fail("span_v",
               fmt::format("0 V at the regulator means {}, which does not vent: a module without power, or whose "
                           "watchdog acts, would set it",
                           analysis::both_units(zero_volt_psi(config), 1)),
               "use a regulator that vents at 0 V, or name the device that relieves the chamber: relief = \"...\"");
  }
  const Volts at_zero = span.voltage(Psi(0.0));
  const bool within = at_zero >= span.volts_low && at_zero <= span.volts_high;
  if (!within || at_zero < Volts(output.low) || at_zero > Volts(output.high)) {
    table.fail("span_v",
               fmt::format("0 psi needs {:.2f} V, but the regulator accepts {:g} to {:g} V and the module gives {:g} "
                           "to {:g} V: the chamber could never be vented",
                           at_zero.value(), span.volts_low.value(), span.volts_high.value(), output.low, output.high),
               "correct span_v and span_bar, or drive the regulator by a module that reaches this voltage");
  }
  if (!zero_volt_vents(config)) regulator.rest = at_zero;
}

void read_module_regulator(const TomlTable& table, BenchConfig& config) {
  devices::RegulatorOptions& regulator = config.regulator;
  read_keys(table, named_keys(regulator));
  read_keys(table, module_regulator_keys(regulator));
  check_zero_volt(table, config);
  const double feed_ms = std::chrono::duration<double, std::milli>(regulator.feed_interval).count();
  if (config.watchdog_s > 0.0 && feed_ms / 1000.0 > 0.6 * config.watchdog_s) {
    table.fail(
        "feed_interval_ms",
        fmt::format("feeding every {:g} ms is too slow for a watchdog of {:g} ms", feed_ms, 1000.0 * config.watchdog_s),
        "keep it at or below 0.6 of [module] watchdog_ms");
  }
}

void read_serial_regulator(const TomlTable& table, BenchConfig& config) {
  devices::RegulatorOptions& regulator = config.regulator;
  regulator.model = "Alicat PCD-100PSIG-D";
  read_keys(table, named_keys(regulator));
  read_keys(table, serial_regulator_keys(config));
  const devices::SerialAddress& line = config.controller_address;
  if (line.port.empty() && line.usb_serial.empty() && !config.in_process) {
    table.fail("port", "no serial port is named", "e.g. \"/dev/ttyUSB1\", or usb_serial of its adapter");
  }
  if (config.controller.pressure_field == config.controller.setpoint_field) {
    table.fail("setpoint_field", "pressure and set-point are read from one field",
               "see the controller's own list of its data fields");
  }
  if (regulator.relief.empty()) {
    table.fail("relief",
               "a serial pressure controller has no watchdog: if its line or its power fails, it may keep the chamber "
               "under pressure",
               "name the device that relieves the chamber, e.g. relief = \"relief valve, 62 psi, and a hand valve\"");
  }
}

// In the order of RegulatorKind.
constexpr struct {
  const char* word;
  void (*read_modules)(const TomlTable& root, BenchConfig& config);
  void (*read)(const TomlTable& table, BenchConfig& config);
} kRegulators[] = {{"module", read_modules, read_module_regulator},
                   {"serial", read_reading_module, read_serial_regulator}};

KeyTable kind_keys(BenchConfig& config) {
  return {key::word("kind", config.regulator_kind, words_of(kRegulators),
                    "How it is commanded: by a voltage of the analog module, or as a pressure controller with ASCII "
                    "commands on a serial line (as Alicat)")};
}

void read_regulator(const TomlTable& root, BenchConfig& config) {
  const TomlTable table = root.table("regulator");
  read_keys(table, kind_keys(config));
  const auto& kind = row_of(kRegulators, config.regulator_kind);
  kind.read_modules(root, config);
  kind.read(table, config);
  devices::RegulatorOptions& regulator = config.regulator;
  regulator.feedback_span = regulator.command_span;
  regulator.command_limit = Psi(config.limits.command_psi);
  regulator.origin = config.origin;
  table.finish();
}

KeyTable correction_keys(devices::PressureCorrection& correction) {
  return {key::numbers("reading_psi", correction.reading_psi, {"psi"}, "Readings of the certificate's table, rising"),
          key::numbers("correction_psi", correction.correction_psi, {"psi"},
                       "Correction added at each of these readings; linear in between"),
          key::numbers("expanded_uncertainty_psi", correction.expanded_uncertainty_psi, {"psi"},
                       "Expanded uncertainty of the corrected value at each reading"),
          key::number("coverage_factor", correction.coverage_factor, kOne, {1.0, 4.0},
                      "Coverage factor k of these uncertainties")};
}

devices::PressureCorrection read_correction(const TomlTable& table, bool page_asset = false) {
  devices::PressureCorrection correction;
  if (page_asset) read_keys(table, {key::schema()});
  read_keys(table, correction_keys(correction));
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
  for (std::size_t i = 1; i < points; ++i) {
    const auto corrected = [&](std::size_t at) { return correction.reading_psi[at] + correction.correction_psi[at]; };
    if (corrected(i) > corrected(i - 1)) continue;
    table.fail("correction_psi",
               fmt::format("the corrected pressure does not rise: {} at a reading of {}, and {} at {}",
                           analysis::both_units(corrected(i - 1)), analysis::both_units(correction.reading_psi[i - 1]),
                           analysis::both_units(corrected(i)), analysis::both_units(correction.reading_psi[i])),
               "compare the corrections with the certificate, sign and decimal point included");
  }
  table.finish();
  return correction;
}

KeyTable gauge_keys(GaugeConfig& gauge) {
  return quantity_keys(gauge.quantity, "span_psi", "psi", "Pressures that correspond to raw_span");
}

void read_gauge(const TomlTable& table, BenchConfig& config) {
  GaugeConfig gauge;
  gauge.own_line = has_own_line(table);
  gauge.endpoint = endpoint_or_unit(table, config);
  read_whole(table, gauge_keys(gauge));
  config.reference_gauge = gauge;
}

KeyTable independent_keys(BenchConfig& config) {
  return {key::flag("independent", config.reference_independent,
                    "Whether a separate transducer or gauge measures the pressure; without one the regulator's monitor "
                    "is used, and reports say \"not independently traceable\"")};
}

KeyTable reference_stated_keys(StatedCalibration& stated) {
  return stated_keys(stated, "expanded_uncertainty_psi", {"psi"}, "Number of the calibration certificate; \"\": none",
                     "Expanded uncertainty U of the certificate (k = 2); a correction has its own");
}

constexpr ChainKeys kReferenceChain = {
    "drift_psi",
    "psi",
    "input_limit_v",
    "V",
    "What the certificate covers: the transducer together with the input that reads it, or the transducer alone",
    "Limit of error of the input that reads it, from the data sheet; 0: included in the certificate, or not stated"};

KeyTable reference_limit_keys(BenchConfig& config) {
  ReferenceLimits& limits = config.reference_limits;
  return {
      key::number("hysteresis_psi", limits.hysteresis_psi, {"psi"}, {0.0, 10.0},
                  "Limit of the transducer's hysteresis, to each side; 0: included or not stated"),
      key::number("zero_psi", limits.zero_psi, {"psi"}, {0.0, 10.0},
                  "Limit of the transducer's zero deviation; 0: included or not stated"),
      key::number("temperature_psi", limits.temperature_psi, {"psi"}, {0.0, 10.0},
                  "Limit of the transducer's temperature effect at the bench; 0: included or not stated"),
      key::number("resolution_psi", config.reference_resolution_psi, {"psi"}, {0.0, 10.0},
                  "Resolution of its reading; 0: that of the converter that reads it"),
      key::optional(key::span("certificate_range_psi", config.certificate_low_psi, config.certificate_high_psi, {"psi"},
                              "Lowest and highest pressure of the certificate, beyond which nothing is traceable; "
                              "without it: any, within the readings of a correction"))};
}

KeyTable reference_name_keys(devices::TransducerOptions& reference) {
  return {key::required(key::text("model", reference.model, "Maker and model, stored with each run")),
          key::required(key::text("serial", reference.serial, "Serial number, stored with each run"))};
}

KeyTable channel_keys(devices::TransducerOptions& reference) {
  return {key::number("channel", reference.channel, kOne, {0, 63},
                      "Input of the module that reads it, counted from 0; not the regulator's")};
}

KeyTable reference_span_keys(devices::LinearSpan& span) {
  span.high = Psi(100.0);
  return {key::span("span_v", span.volts_low, span.volts_high, {"V"}, "Lowest and highest voltage of its output ..."),
          key::span("span_psi", span.low, span.high, {"psi"}, "... and the corresponding pressures")};
}

KeyTable correction_file_keys(std::string& file) {
  return {key::optional(key::text("correction_file", file,
                                  "File with a correction, as tactbench devices calibrate-reference writes it; instead "
                                  "of [reference.correction]"))};
}

void read_reference(const TomlTable& table, BenchConfig& config) {
  read_keys(table, independent_keys(config));
  read_keys(table, reference_stated_keys(config.reference_stated));
  check_dates(table, config.reference_stated);
  read_keys(table, chain_keys(config.reference_stated, config.origin, kReferenceChain));
  check_chain(table, config.reference_stated, kReferenceChain.input);
  read_keys(table, reference_limit_keys(config));
  devices::TransducerOptions& reference = config.reference;
  reference.origin = config.origin;
  if (config.reference_independent) read_keys(table, reference_name_keys(reference));
  if (table.has("gauge")) {
    if (!config.reference_independent) {
      table.fail("independent", "a gauge is an independent reference", "set independent = true, or remove the gauge");
    }
    for (const char* key : {"channel", "span_v", "span_psi", "input_limit_v"}) {
      if (table.has(key))
        table.fail(key, "a gauge reads pressure directly", fmt::format("remove '{}' or the gauge", key));
    }
    // "transducer" would require input_limit_v.
    config.reference_stated.covers = "chain";
    read_gauge(table.table("gauge"), config);
  } else if (config.reference_independent) {
    if (!config.module.present()) {
      table.fail("independent", "no [module] reads the transducer",
                 "add [module], or [reference.gauge] with its own line; or set independent = false: the controller's "
                 "own transducer is then used");
    }
    read_keys(table, channel_keys(reference));
    if (config.regulator_kind == RegulatorKind::kModule && reference.channel == config.regulator.feedback_channel) {
      table.fail("channel", "the reference shares the regulator's feedback channel",
                 "wire the transducer to a separate input, or set independent = false");
    }
    read_keys(table, reference_span_keys(reference.span));
  } else {  // the regulator's own monitor output serves as reference
    reference.model = config.regulator.model + " (feedback)";
    reference.serial = config.regulator.serial;
    reference.channel = config.regulator.feedback_channel;
    reference.span = config.regulator.feedback_span;
  }
  if (table.has("correction")) config.reference_correction = read_correction(table.table("correction"));
  std::string correction_file;
  read_keys(table, correction_file_keys(correction_file));
  if (table.has("correction_file")) {
    if (table.has("correction")) {
      table.fail("correction_file", "the correction is given twice", "keep [reference.correction] or correction_file");
    }
    // Relative to the bench file, as its other relative names.
    const auto path = std::filesystem::path(config.file).parent_path() / correction_file;
    const auto document = sequences::TomlDocument::from_file(path.string());
    config.reference_correction = read_correction(document.root(), true);
  }
  table.finish();
}

KeyTable sensor_keys(EnvironmentSensor& sensor) {
  return {key::required(key::word("quantity", sensor.quantity, {"temperature_c", "supply_bar"},
                                  "What the sensor measures; stored at the start and the end of each run")),
          key::text("model", sensor.model, "Maker and model, stored with each run"),
          key::text("serial", sensor.serial, "Serial number, stored with each run")};
}

KeyTable thermometer_keys(EnvironmentSensor& sensor) {
  return quantity_keys(sensor.place, "span_c", "°C", "Temperatures that correspond to raw_span");
}

KeyTable supply_keys(EnvironmentSensor& sensor) {
  return quantity_keys(sensor.place, "span_bar", "bar", "Supply pressures that correspond to raw_span");
}

KeyTable sensor_stated_keys(StatedCalibration& stated) {
  return stated_keys(stated, "expanded_uncertainty_c", {"°C"},
                     "Thermometer: number of its calibration certificate; \"\": none",
                     "Expanded uncertainty U of a temperature (k = 2)");
}

constexpr ChainKeys kSensorChain = {
    "drift_c",
    "°C",
    "input_limit_c",
    "°C",
    "What that certificate covers: the sensor together with the input that reads it, or the sensor alone",
    "Limit of error of the input that reads it, from the data sheet; 0: included in the certificate, or not stated"};

EnvironmentSensor read_sensor(const TomlTable& table, const BenchConfig& config) {
  EnvironmentSensor sensor;
  read_keys(table, sensor_keys(sensor));
  const bool thermometer = sensor.quantity == "temperature_c";
  sensor.own_line = has_own_line(table);
  sensor.endpoint = endpoint_or_unit(table, config);
  read_keys(table, thermometer ? thermometer_keys(sensor) : supply_keys(sensor));
  if (thermometer) {
    read_keys(table, sensor_stated_keys(sensor.stated));
    check_dates(table, sensor.stated);
    read_keys(table, chain_keys(sensor.stated, config.origin, kSensorChain));
    check_chain(table, sensor.stated, kSensorChain.input);
  }
  table.finish();
  return sensor;
}

}  // namespace

double zero_volt_psi(const BenchConfig& config) { return config.regulator.command_span.driven(Volts(0.0)).value(); }

bool on_serial_line(const BenchConfig& config) {
  return config.regulator_kind == RegulatorKind::kSerial || !config.module.endpoint.serial_port.empty();
}

bool zero_volt_vents(const BenchConfig& config) { return std::abs(zero_volt_psi(config)) < config.limits.safe_psi; }

void read_pressure(const TomlTable& root, BenchConfig& config) {
  read_regulator(root, config);
  read_reference(root.table("reference"), config);
  const TomlTable environment = root.table("environment");
  for (const TomlTable& sensor : environment.tables("sensor")) {
    config.environment.push_back(read_sensor(sensor, config));
  }
  environment.finish();
}

void add_pressure_keys(std::vector<sequences::KeyFacts>& all) {
  constexpr auto kSimulated = devices::Origin::kSimulated;
  BenchConfig config;
  std::string text;
  const auto add = [&](const std::string& path, std::initializer_list<KeyTable> tables) {
    for (const KeyTable& keys : tables) add_facts(all, path, keys);
  };
  for (const bool first : {true, false}) {
    const std::string path = first ? "module" : "input_module";
    add(path, {profile_keys(text, first ? kOfModule : kOfInputModule), output_keys(config.module.profile),
               input_keys(config.module.profile)});
    add_endpoint_keys(all, path);
    if (first) add(path, {watchdog_keys(config), dump_keys(config.module.profile)});
  }
  add("regulator", {kind_keys(config), named_keys(config.regulator), module_regulator_keys(config.regulator),
                    serial_regulator_keys(config)});
  StatedCalibration& stated = config.reference_stated;
  add("reference",
      {independent_keys(config), reference_stated_keys(stated), chain_keys(stated, kSimulated, kReferenceChain),
       reference_limit_keys(config), reference_name_keys(config.reference), channel_keys(config.reference),
       reference_span_keys(config.reference.span), correction_file_keys(text)});
  GaugeConfig gauge;
  add_endpoint_keys(all, "reference.gauge");
  add("reference.gauge", {gauge_keys(gauge)});
  add("reference.correction", {correction_keys(config.reference_correction)});
  EnvironmentSensor sensor;
  const std::string path = "environment.sensor[]";
  add(path, {sensor_keys(sensor)});
  add_endpoint_keys(all, path);
  add(path, {thermometer_keys(sensor), supply_keys(sensor), sensor_stated_keys(sensor.stated),
             chain_keys(sensor.stated, kSimulated, kSensorChain)});
}

}  // namespace tactbench::bench
