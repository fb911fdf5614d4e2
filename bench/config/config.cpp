#include "bench/config/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "bench/common/build_info.h"
#include "bench/config/config_instruments.h"
#include "bench/config/config_pressure.h"
#include "bench/config/config_simulation.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

void read_force_limits(const TomlTable& table, SafetyLimits& limits) {
  if (!table.has("force_n")) return;
  const std::vector<double> force = table.numbers("force_n");
  const auto usable = [](double newtons) { return newtons > 0.0 && newtons <= 100.0; };
  if (force.size() != 3 || !std::all_of(force.begin(), force.end(), usable)) {
    table.fail("force_n", "'force_n' must hold three numbers above 0 up to 100", "write [fx, fy, fz] in N");
  }
  std::copy(force.begin(), force.end(), limits.force_n.begin());
}

KeyTable safety_keys(SafetyLimits& limits) {
  Key trip = key::number("trip_psi", limits.trip_psi, {"psi"}, {},
                         "A pressure measured above this aborts the run, vents the chamber and latches a trip");
  trip.facts.range = "command_psi to 110";  // checked when both are read
  // The regulator could exceed the chamber's limit; no file may raise these.
  return {
      key::number("command_psi", limits.command_psi, {"psi"}, {1.0, 100.0}, "No set-point above this is ever sent"),
      trip,
      key::number("safe_psi", limits.safe_psi, {"psi"}, {0.1, 1.0},
                  "The chamber counts as vented when two witnesses read less than this"),
      key::number("disagreement_psi", limits.disagreement_psi, {"psi"}, {0.1, 50.0},
                  "Feedback and reference may differ by at most this much ..."),
      key::number("disagreement_s", limits.disagreement_s, {"s"}, {0.2, 60.0},
                  "... for this long; then the run is aborted and the chamber vented"),
      key::number("vent_timeout_s", limits.vent_timeout_s, {"s"}, {1.0, 120.0},
                  "Longest time that venting may take before the safe state counts as not verified"),
      key::number("rate_psi_per_s", limits.rate_psi_per_s, {"psi/s"}, {0.01, 200.0},
                  "The set-point never rises faster than this"),
      key::number("step_psi", limits.step_psi, {"psi"}, {0.01, 100.0},
                  "The set-point never rises by more than this at once"),
      key::number("stale_s", limits.stale_s, {"s"}, {0.1, 10.0},
                  "Readings of pressure older than this refuse more load"),
      key::number("contact_n", limits.contact_n, {"N"}, {0.05, 5.0},
                  "From this force on the object counts as touching, and x and y must stand still"),
      key::number("clear_z_mm", limits.clear_z_mm, {"mm"}, {0.0, 1000.0},
                  "x and y move only while z is at or below this position"),
      key::made({"force_n", "list of numbers", "N", "each above 0, to 100",
                 fmt::format("`[{}]`", fmt::join(limits.force_n, ", ")),
                 "Largest force on each axis [x, y, z]; beyond it the stage stops, backs off and a trip is latched"},
                [&limits](const TomlTable& table) { read_force_limits(table, limits); })};
}

KeyTable dead_man_keys(DeadManConfig& dead_man) {
  return {key::flag("enabled", dead_man.enabled,
                    "Starts a second process that vents and retracts when the program dies or hangs; a bench that is "
                    "simulated inside the program needs none"),
          key::number("timeout_ms", dead_man.timeout_s, kMilliseconds, {100.0, 5000.0},
                      "It acts when the program has given no sign of life for this long"),
          key::number("progress_ms", dead_man.progress_s, kMilliseconds, {250.0, 30000.0},
                      "It acts when the program's work has made no progress for this long"),
          key::number("back_off_mm", dead_man.back_off_mm, {"mm"}, {0.0, 50.0},
                      "How far it moves z back after stopping the stage"),
          key::word("blind", dead_man.blind_ends, {"end", "warn"}, "end",
                    "What a run does when the dead-man cannot reach the module twice in a row: end, or only warn")};
}

KeyTable settling_keys(Settling& settling) {
  return {key::number("band_psi", settling.band_psi, {"psi"}, {0.01, 5.0},
                      "A level counts as reached when the feedback is within this distance of the set-point ..."),
          key::number("slope_psi_per_s", settling.slope_psi_per_s, {"psi/s"}, {0.01, 100.0},
                      "... and the reference changes more slowly than this; the dwell begins then"),
          key::number("poll_s", settling.poll_s, {"s"}, {0.01, 0.5},
                      "Time between two readings of pressure while a level settles; all are stored"),
          key::number("trace_s", settling.trace_s, {"s"}, {0.05, 10.0, true},
                      "Time between two readings of pressure during the dwell; 0: each time the module is fed"),
          key::number("landing_s", settling.landing_s, {"s"}, {0.0, 10.0},
                      "Rest before the last step of a ramp, so that it overshoots as little as a small step"),
          key::number("timeout_s", settling.timeout_s, {"s"}, {1.0, 600.0},
                      "A level that has not settled after this time is an error (TB-CHAMBER-TIMEOUT)")};
}

KeyTable identity_keys(BenchConfig& config) {
  return {key::name("id", config.id, "Name of the bench; one run a bench at a time, and stored runs are grouped by it"),
          key::text("location", config.location, "Where it stands; for reports"),
          key::required(key::word("origin", config.origin, {"simulated", "hardware"},
                                  "Whether data come from a simulated rig or from hardware; the two are never mixed"))};
}

KeyTable simulator_keys(BenchConfig& config) {
  return {key::optional(key::word("simulator", config.in_process, {"in-process", "external"}, "in-process",
                                  "Of a simulated bench: the simulation runs inside this program, or in tactbench "
                                  "simulate or another program"))};
}

KeyTable rate_keys(BenchConfig& config) {
  return {key::number("rate", config.rate, kOne, {0.1, 100.0},
                      "How many times faster than real time an external simulator runs")};
}

BenchConfig read_document(sequences::TomlDocument document, const std::vector<sequences::Override>& overrides,
                          const SeedOptions& seeds) {
  for (const sequences::Override& override_value : overrides) document.set(override_value);
  const TomlTable root = document.root();
  BenchConfig config;
  config.file = document.name();
  config.text = document.text();
  config.resolved = document.to_text();
  read_keys(root, {key::schema()});
  const TomlTable bench = root.table("bench");
  read_keys(bench, identity_keys(config));
  const bool simulated = config.origin == devices::Origin::kSimulated;
  config.in_process = simulated;
  if (bench.has("simulator") && !simulated)
    bench.fail("simulator", "a hardware bench has no simulator", "remove it, or set origin = \"simulated\"");
  read_keys(bench, simulator_keys(config));
  if (!config.in_process && simulated) read_keys(bench, rate_keys(config));
  bench.finish();
  if (root.has("simulation") && !config.in_process) {
    root.fail("simulation",
              simulated ? "an external simulator has its own [simulation] table"
                        : "a hardware bench has a [simulation] table",
              "remove it, or set origin = \"simulated\": simulated data must never be taken for real data");
  }
  const TomlTable limits = root.table("limits");
  read_whole(limits, safety_keys(config.limits));
  limits.check_range("trip_psi", config.limits.trip_psi, config.limits.command_psi, 110.0);
  read_whole(root.table("dead_man"), dead_man_keys(config.dead_man));
  read_whole(root.table("settling"), settling_keys(config.settling));
  read_pressure(root, config);
  if (!config.dead_man.blind_ends && (config.watchdog_s <= 0.0 || !zero_volt_vents(config))) {
    root.table("dead_man")
        .fail("blind", "blind = \"warn\" on a module without a watchdog that tactbench sets and that vents",
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

std::vector<sequences::KeyFacts> bench_keys() {
  BenchConfig config;
  config.in_process = true;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", {key::schema()});
  for (const KeyTable& keys : {identity_keys(config), simulator_keys(config), rate_keys(config)})
    add_facts(all, "bench", keys);
  add_facts(all, "limits", safety_keys(config.limits));
  add_facts(all, "dead_man", dead_man_keys(config.dead_man));
  add_facts(all, "settling", settling_keys(config.settling));
  add_pressure_keys(all);
  add_instrument_keys(all);
  add_simulation_keys(all);
  return all;
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
  if (std::string here = name + ".toml"; !name.empty() && std::filesystem::exists(here, unusable)) return here;
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
