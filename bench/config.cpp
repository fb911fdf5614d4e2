#include "bench/config.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "bench/config_simulation.h"
#include "bench/process_time.h"

namespace tactbench::bench {

using devices::Psi;
using devices::Volts;
using sequences::TomlTable;

namespace {

devices::Nanoseconds milliseconds(double value) { return seconds(value / 1000.0); }

SafetyLimits read_safety(const TomlTable& table) {
  SafetyLimits limits;
  // The regulator could exceed what the chamber bears; no file may raise these.
  limits.command_psi = table.number_in("command_psi", limits.command_psi, 1.0, 100.0);
  limits.trip_psi = table.number_in("trip_psi", limits.trip_psi, limits.command_psi, 110.0);
  limits.safe_psi = table.number_in("safe_psi", limits.safe_psi, 0.1, 1.0);
  limits.vent_timeout_s = table.number_in("vent_timeout_s", limits.vent_timeout_s, 1.0, 120.0);
  table.finish();
  return limits;
}

Settling read_settling(const TomlTable& table) {
  Settling settling;
  settling.band_psi = table.number_in("band_psi", settling.band_psi, 0.01, 5.0);
  settling.slope_psi_per_s = table.number_in("slope_psi_per_s", settling.slope_psi_per_s, 0.01, 100.0);
  settling.poll_s = table.number_in("poll_s", settling.poll_s, 0.01, 0.5);
  settling.timeout_s = table.number_in("timeout_s", settling.timeout_s, 1.0, 600.0);
  table.finish();
  return settling;
}

void read_module(const TomlTable& table, BenchConfig& config) {
  config.module_profile = table.text("profile");
  config.module.host = table.text("host", config.module.host);
  config.module.port = static_cast<int>(table.integer("port", 502, 0, 65535));
  config.module.unit = static_cast<int>(table.integer("unit", 1, 0, 255));
  config.module.response_timeout = milliseconds(table.number_in("response_timeout_ms", 500, 10, 10000));
  config.watchdog_s = table.number_in("watchdog_ms", 1000, 500, 60000) / 1000.0;
  table.finish();
  (void)devices::module_profile(config.module_profile);  // refuses an unknown one before any device is touched
}

devices::LinearSpan read_span(const TomlTable& table, const std::string& pressure_key, double per_unit,
                              std::pair<double, double> pressure_default) {
  const auto volts = table.span("span_v", {0.0, 10.0});
  const auto pressure = table.span(pressure_key, pressure_default);
  return {Volts(volts.first), Volts(volts.second), Psi(pressure.first * per_unit), Psi(pressure.second * per_unit)};
}

void read_regulator(const TomlTable& table, BenchConfig& config) {
  devices::RegulatorOptions& regulator = config.regulator;
  regulator.model = table.text("model", regulator.model);
  regulator.serial = table.text("serial");
  regulator.output_channel = static_cast<int>(table.integer("output_channel", 0, 0, 7));
  regulator.feedback_channel = static_cast<int>(table.integer("feedback_channel", 0, 0, 7));
  regulator.command_span = read_span(table, "span_bar", devices::kPsiPerBar, {0.0, 9.0});
  regulator.feedback_span = regulator.command_span;
  const double feed_ms = table.number_in("feed_interval_ms", 450, 50, 500);
  if (feed_ms / 1000.0 > 0.6 * config.watchdog_s) {
    table.fail(
        "feed_interval_ms",
        fmt::format("feeding every {:g} ms is too slow for a watchdog of {:g} ms", feed_ms, 1000.0 * config.watchdog_s),
        "keep it at or below 0.6 of [module] watchdog_ms");
  }
  regulator.feed_interval = milliseconds(feed_ms);
  regulator.command_limit = Psi(config.limits.command_psi);
  regulator.origin = config.origin;
  table.finish();
}

void read_reference(const TomlTable& table, BenchConfig& config) {
  config.reference_independent = table.boolean("independent", true);
  config.reference_certificate = table.text("certificate", "");
  config.reference_due = table.text("due", "");
  devices::TransducerOptions& reference = config.reference;
  reference.origin = config.origin;
  if (config.reference_independent) {
    reference.model = table.text("model");
    reference.serial = table.text("serial");
    reference.channel = static_cast<int>(table.integer("channel", 1, 0, 7));
    if (reference.channel == config.regulator.feedback_channel) {
      table.fail("channel", "the reference shares the regulator's feedback channel",
                 "wire the transducer to an input of its own, or set independent = false");
    }
    reference.span = read_span(table, "span_psi", 1.0, {0.0, 100.0});
  } else {  // the regulator's own monitor output stands in
    reference.model = config.regulator.model + " (feedback)";
    reference.serial = config.regulator.serial;
    reference.channel = config.regulator.feedback_channel;
    reference.span = config.regulator.feedback_span;
  }
  table.finish();
}

void read_scanner(const TomlTable& table, BenchConfig& config) {
  config.scanner.model = table.text("model", config.scanner.model);
  config.scanner.expected_serial = table.text("serial", "");
  config.scanner.rows = static_cast<int>(table.integer("rows", 16, 1, 64));
  config.scanner.columns = static_cast<int>(table.integer("columns", 16, 16, 16));
  config.scanner.frame_timeout = milliseconds(table.number_in("frame_timeout_ms", 500, 10, 10000));
  config.scanner.origin = config.origin;
  config.scans_per_frame = static_cast<int>(table.integer("scans_per_frame", 2, 1, 8));
  config.scanner_address.vendor_id = static_cast<std::uint16_t>(table.integer("vendor_id", 0, 0, 65535));
  config.scanner_address.product_id = static_cast<std::uint16_t>(table.integer("product_id", 0, 0, 65535));
  config.scanner_address.serial = config.scanner.expected_serial;
  table.finish();
}

}  // namespace

BenchConfig read_bench(const std::string& path, const std::vector<sequences::Override>& overrides,
                       const SeedOptions& seeds) {
  sequences::TomlDocument document = sequences::TomlDocument::from_file(path);
  for (const sequences::Override& override_value : overrides) document.set(override_value);
  const TomlTable root = document.root();
  BenchConfig config;
  config.file = path;
  config.text = document.text();
  (void)root.integer("schema", 1, 1);
  const TomlTable bench = root.table("bench");
  config.id = bench.text("id");
  config.location = bench.text("location", "not stated");
  config.origin = bench.word("origin", {"simulated", "hardware"}) == "simulated" ? devices::Origin::kSimulated
                                                                                 : devices::Origin::kHardware;
  bench.finish();
  config.limits = read_safety(root.table("limits"));
  config.settling = read_settling(root.table("settling"));
  read_module(root.table("module"), config);
  read_regulator(root.table("regulator"), config);
  read_reference(root.table("reference"), config);
  read_scanner(root.table("scanner"), config);
  const bool simulated = config.origin == devices::Origin::kSimulated;
  if (root.has("simulation") && !simulated) {
    root.fail("simulation", "a hardware bench has a [simulation] table",
              "remove it, or set origin = \"simulated\": simulated data must never pass for real");
  }
  if (simulated) config.simulation = read_simulation(root.table("simulation"), config, seeds);
  root.finish();
  return config;
}

std::string share_folder() {
  const char* folder = std::getenv("TACTBENCH_SHARE");
  return folder != nullptr && *folder != '\0' ? folder : TACTBENCH_SOURCE_DIR;
}

namespace {

std::string find_in(const std::string& folder, const std::string& name) {
  if (std::filesystem::exists(name)) return name;
  for (const char* ending : {"", ".toml"}) {
    std::string candidate = fmt::format("{}/{}/{}{}", share_folder(), folder, name, ending);
    if (name.find('/') == std::string::npos && std::filesystem::exists(candidate)) return candidate;
  }
  return name;
}

}  // namespace

std::string find_recipe(const std::string& name) { return find_in("sequences", name); }
std::string find_config(const std::string& name) { return find_in("bench/config", name); }

}  // namespace tactbench::bench
