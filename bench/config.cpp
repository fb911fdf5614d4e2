#include "bench/config.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "bench/config_pressure.h"
#include "bench/config_simulation.h"
#include "bench/process_time.h"

namespace tactbench::bench {

using sequences::TomlTable;

namespace {

devices::Nanoseconds milliseconds(double value) { return seconds(value / 1000.0); }

SafetyLimits read_safety(const TomlTable& table) {
  SafetyLimits limits;
  // The regulator could exceed what the chamber bears; no file may raise these.
  limits.command_psi = table.number_in("command_psi", limits.command_psi, 1.0, 100.0);
  limits.trip_psi = table.number_in("trip_psi", limits.trip_psi, limits.command_psi, 110.0);
  limits.safe_psi = table.number_in("safe_psi", limits.safe_psi, 0.1, 1.0);
  limits.disagreement_psi = table.number_in("disagreement_psi", limits.disagreement_psi, 0.1, 50.0);
  limits.disagreement_s = table.number_in("disagreement_s", limits.disagreement_s, 0.2, 60.0);
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
  read_pressure(root, config);
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
