#include "bench/config/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "bench/common/build_info.h"
#include "bench/config/config_instruments.h"
#include "bench/config/config_pressure.h"
#include "bench/config/config_simulation.h"

namespace tactbench::bench {

using sequences::TomlTable;

namespace {

SafetyLimits read_safety(const TomlTable& table) {
  SafetyLimits limits;
  // The regulator could exceed the chamber's limit; no file may raise these.
  limits.command_psi = table.number_in("command_psi", limits.command_psi, 1.0, 100.0);
  limits.trip_psi = table.number_in("trip_psi", limits.trip_psi, limits.command_psi, 110.0);
  limits.safe_psi = table.number_in("safe_psi", limits.safe_psi, 0.1, 1.0);
  limits.disagreement_psi = table.number_in("disagreement_psi", limits.disagreement_psi, 0.1, 50.0);
  limits.disagreement_s = table.number_in("disagreement_s", limits.disagreement_s, 0.2, 60.0);
  limits.vent_timeout_s = table.number_in("vent_timeout_s", limits.vent_timeout_s, 1.0, 120.0);
  limits.rate_psi_per_s = table.number_in("rate_psi_per_s", limits.rate_psi_per_s, 0.01, 200.0);
  limits.step_psi = table.number_in("step_psi", limits.step_psi, 0.01, 100.0);
  limits.stale_s = table.number_in("stale_s", limits.stale_s, 0.1, 10.0);
  limits.contact_n = table.number_in("contact_n", limits.contact_n, 0.05, 5.0);
  limits.clear_z_mm = table.number_in("clear_z_mm", limits.clear_z_mm, 0.0, 1000.0);
  if (table.has("force_n")) {
    const std::vector<double> force = table.numbers("force_n");
    const auto usable = [](double newtons) { return newtons > 0.0 && newtons <= 100.0; };
    if (force.size() != 3 || !std::all_of(force.begin(), force.end(), usable)) {
      table.fail("force_n", "'force_n' must hold three numbers above 0 up to 100", "write [fx, fy, fz] in N");
    }
    std::copy(force.begin(), force.end(), limits.force_n.begin());
  }
  table.finish();
  return limits;
}

DeadManConfig read_dead_man(const TomlTable& table) {
  DeadManConfig dead_man;
  dead_man.enabled = table.boolean("enabled", dead_man.enabled);
  dead_man.timeout_s = table.number_in("timeout_ms", 1000.0 * dead_man.timeout_s, 100.0, 5000.0) / 1000.0;
  dead_man.progress_s = table.number_in("progress_ms", 1000.0 * dead_man.progress_s, 250.0, 30000.0) / 1000.0;
  dead_man.back_off_mm = table.number_in("back_off_mm", dead_man.back_off_mm, 0.0, 50.0);
  dead_man.blind_ends = table.word("blind", "end", {"end", "warn"}) == "end";
  table.finish();
  return dead_man;
}

Settling read_settling(const TomlTable& table) {
  Settling settling;
  settling.band_psi = table.number_in("band_psi", settling.band_psi, 0.01, 5.0);
  settling.slope_psi_per_s = table.number_in("slope_psi_per_s", settling.slope_psi_per_s, 0.01, 100.0);
  settling.poll_s = table.number_in("poll_s", settling.poll_s, 0.01, 0.5);
  settling.trace_s = table.zero_or_in("trace_s", settling.trace_s, 0.05, 10.0);
  settling.landing_s = table.number_in("landing_s", settling.landing_s, 0.0, 10.0);
  settling.timeout_s = table.number_in("timeout_s", settling.timeout_s, 1.0, 600.0);
  table.finish();
  return settling;
}

}  // namespace

namespace {

BenchConfig read_document(sequences::TomlDocument document, const std::vector<sequences::Override>& overrides,
                          const SeedOptions& seeds) {
  for (const sequences::Override& override_value : overrides) document.set(override_value);
  const TomlTable root = document.root();
  BenchConfig config;
  config.file = document.name();
  config.text = document.text();
  config.resolved = document.to_text();
  (void)root.integer("schema", 1, 1);
  const TomlTable bench = root.table("bench");
  config.id = bench.name("id");
  config.location = bench.text("location", "not stated");
  config.origin = bench.word("origin", {"simulated", "hardware"}) == "simulated" ? devices::Origin::kSimulated
                                                                                 : devices::Origin::kHardware;
  const bool simulated = config.origin == devices::Origin::kSimulated;
  config.in_process = simulated;
  if (bench.has("simulator")) {
    if (!simulated) {
      bench.fail("simulator", "a hardware bench has no simulator", "remove it, or set origin = \"simulated\"");
    }
    config.in_process = bench.word("simulator", {"in-process", "external"}) == "in-process";
  }
  if (!config.in_process && simulated) config.rate = bench.number_in("rate", 1.0, 0.1, 100.0);
  bench.finish();
  if (root.has("simulation") && !config.in_process) {
    root.fail("simulation",
              simulated ? "an external simulator has its own [simulation] table"
                        : "a hardware bench has a [simulation] table",
              "remove it, or set origin = \"simulated\": simulated data must never be taken for real data");
  }
  config.limits = read_safety(root.table("limits"));
  config.dead_man = read_dead_man(root.table("dead_man"));
  config.settling = read_settling(root.table("settling"));
  read_pressure(root, config);
  if (!config.dead_man.blind_ends && config.watchdog_s <= 0.0) {
    root.table("dead_man")
        .fail("blind", "blind = \"warn\" on a module without a watchdog that tactbench sets",
              "write blind = \"end\": when the dead-man cannot reach this module, nothing else would "
              "vent");
  }
  read_instruments(root, config);
  if (config.in_process) config.simulation = read_simulation(root.table("simulation"), config, seeds);
  root.finish();
  config.settings = document.settings();
  return config;
}

}  // namespace

BenchConfig read_bench(const std::string& path, const std::vector<sequences::Override>& overrides,
                       const SeedOptions& seeds) {
  return read_document(sequences::TomlDocument::from_file(path), overrides, seeds);
}

BenchConfig parse_bench(const std::string& text, const std::string& name,
                        const std::vector<sequences::Override>& overrides, const SeedOptions& seeds) {
  return read_document(sequences::TomlDocument::from_text(text, name), overrides, seeds);
}

std::string share_folder() {
  const char* folder = std::getenv("TACTBENCH_SHARE");
  if (folder != nullptr && *folder != '\0') return folder;
  std::error_code unreadable;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unreadable);
  const std::filesystem::path installed = program.parent_path().parent_path() / "share/tactbench";
  return std::filesystem::is_directory(installed, unreadable) ? installed.string() : build_info().source_folder;
}

std::vector<std::string> shipped_files(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(share_folder() + "/" + folder, missing)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

namespace {

std::string find_in(const std::string& folder, const std::string& name, bool with_ending, const char* what) {
  std::error_code unusable;  // an invalid name counts as a missing file
  if (name.find('/') != std::string::npos || std::filesystem::exists(name, unusable)) return name;
  for (const char* ending : {"", ".toml"}) {
    std::string candidate = fmt::format("{}/{}/{}{}", share_folder(), folder, name, ending);
    if (!name.empty() && std::filesystem::exists(candidate, unusable)) return candidate;
  }
  std::vector<std::string> shipped = shipped_files(folder);
  if (!with_ending) {
    for (std::string& file : shipped) file.erase(file.rfind('.'));
  }
  const std::string near = sequences::nearest_word(name, shipped);
  throw sequences::FileError(
      "TB-FILE-MISSING", fmt::format("there is no file '{}', and no shipped {} of that name", name, what), name,
      fmt::format("{}shipped: {}{}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                  fmt::join(shipped, ", "), with_ending ? "; 'tactbench init' writes files to start from" : ""));
}

}  // namespace

std::string find_recipe(const std::string& name) { return find_in("sequences", name, false, "recipe or suite"); }
std::string find_config(const std::string& name) { return find_in("bench/config", name, true, "configuration"); }

}  // namespace tactbench::bench
