#include "bench/config/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "bench/common/build_info.h"
#include "bench/config/config_pressure.h"
#include "bench/config/config_simulation.h"
#include "bench/config/instrument_kinds.h"
#include "db/run_store.h"
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
                  "The chamber counts as vented when both pressure instruments read less than this"),
      key::number("disagreement_psi", limits.disagreement_psi, {"psi"}, {0.1, 50.0},
                  "Feedback and reference may differ by at most this much ..."),
      key::number("disagreement_s", limits.disagreement_s, {"s"}, {0.2, 60.0},
                  "... for this long; then the run is aborted and the chamber vented"),
      key::number("vent_timeout_s", limits.vent_timeout_s, {"s"}, {1.0, 120.0},
                  "Longest time that venting may take before the safe state counts as not verified"),
      key::number("rate_psi_per_s", limits.rate_psi_per_s, {"psi/s"}, {0.01, 200.0},
                  "The set-point never rises faster than this"),
      key::number("step_psi", limits.step_psi, {"psi"}, {0.01, 100.0},
                  "The set-point never rises by more than this in one step"),
      key::number("stale_s", limits.stale_s, {"s"}, {0.1, 10.0},
                  "The load is not increased if the last pressure reading is older than this"),
      key::number("contact_n", limits.contact_n, {"N"}, {0.05, 5.0},
                  "From this force on the object counts as touching, and x and y must not move"),
      key::number("clear_z_mm", limits.clear_z_mm, {"mm"}, {0.0, 1000.0},
                  "x and y move only while z is at or below this position"),
      key::made({"force_n", "list of numbers", "N", "each above 0, to 100",
                 fmt::format("`[{}]`", fmt::join(limits.force_n, ", ")),
                 "Largest force on each axis [x, y, z]; beyond it the stage stops, backs off and a trip is latched"},
                [&limits](const TomlTable& table) { read_force_limits(table, limits); })};
}

KeyTable dead_man_keys(DeadManConfig& dead_man) {
  return {key::flag("enabled", dead_man.enabled,
                    "Starts a second process that vents and retracts when the program dies or hangs; not needed by a "
                    "bench simulated inside the program"),
          key::number("timeout_ms", dead_man.timeout_s, kMilliseconds, {100.0, 5000.0},
                      "The dead-man acts when the program has given no sign of life for this long"),
          key::number("progress_ms", dead_man.progress_s, kMilliseconds, {250.0, 30000.0},
                      "The dead-man acts when the program's work has made no progress for this long"),
          key::number("back_off_mm", dead_man.back_off_mm, {"mm"}, {0.0, 50.0},
                      "How far the dead-man moves z back after stopping the stage"),
          key::word("blind", dead_man.blind_ends, {"end", "warn"}, "end",
                    "What a run does when the dead-man cannot reach the module twice in a row: end, or only warn")};
}

KeyTable settling_keys(Settling& settling) {
  return {
      key::number("band_psi", settling.band_psi, {"psi"}, {0.01, 5.0},
                  "A level counts as reached when the feedback is within this distance of the set-point ..."),
      key::number("slope_psi_per_s", settling.slope_psi_per_s, {"psi/s"}, {0.01, 100.0},
                  "... and the reference changes more slowly than this; the dwell begins then"),
      key::number("poll_s", settling.poll_s, {"s"}, {0.01, 0.5},
                  "Time between two readings of pressure while a level settles; all are stored"),
      key::number("trace_s", settling.trace_s, {"s"}, {0.05, 10.0, true},
                  "Time between two readings of pressure during the dwell; 0: each time the module's watchdog is fed"),
      key::number("landing_s", settling.landing_s, {"s"}, {0.0, 10.0},
                  "Rest before the last step of a ramp, so that it overshoots as little as a small step"),
      key::number("timeout_s", settling.timeout_s, {"s"}, {1.0, 600.0},
                  "A level that has not settled after this time is an error (TB-CHAMBER-TIMEOUT)")};
}

KeyTable identity_keys(BenchConfig& config) {
  return {key::name("id", config.id,
                    "Name of the bench; a bench carries out one run at a time, and stored runs are grouped by it"),
          key::text("location", config.location, "Location of the bench; for reports"),
          key::required(key::word("origin", config.origin, {"simulated", "hardware"},
                                  "Whether data come from a simulated rig or from hardware; the two are never mixed"))};
}

KeyTable simulator_keys(BenchConfig& config) {
  return {key::optional(key::word("simulator", config.in_process, {"in-process", "external"}, "in-process",
                                  "For a simulated bench: whether the simulation runs inside this program, or in "
                                  "tactbench simulate or another program"))};
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
              "remove it, or set origin = \"simulated\": simulated data must never be mistaken for real data");
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
              "write blind = \"end\": if the dead-man cannot reach this module, nothing else would vent");
  }
  read_scanner(root.table("scanner"), config);
  if (root.has("stage")) read_stage(root.table("stage"), config);
  if (root.has("force")) read_force(root.table("force"), config);
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
  add_scanner_keys(all);
  add_stage_keys(all);
  add_force_keys(all);
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
      "TB-FILE-MISSING", fmt::format("there is no file '{}' and no shipped {} of that name", name, what), name,
      fmt::format("{}shipped: {}{}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                  fmt::join(shipped, ", "), with_ending ? "; 'tactbench init' writes files to start from" : ""));
}

}  // namespace

std::string find_recipe(const std::string& name) { return find_in("sequences", name, false, "recipe or suite"); }
std::string find_config(const std::string& name) { return find_in("bench/config", name, true, "configuration"); }

// Sensor type file and limits file.

using sequences::kPercent;
using sequences::TomlDocument;

namespace {

constexpr sequences::Unit kPercentOfFullScale{"% of full scale", 1.0, 100.0};

KeyTable type_keys(SensorType& type) {
  return {key::schema(), key::name("name", type.name, "Name of the sensor type; on reports"),
          key::required(key::number("rows", type.rows, kOne, {1, 64}, "Rows of the array")),
          key::required(key::number("columns", type.columns, kOne, {1, 64}, "Columns of the array")),
          key::number("pitch_mm", type.pitch_mm, {"mm"}, {0.01, 100.0}, "Distance of two neighbouring taxels")};
}

KeyTable geometry_keys(SensorType& type) {
  type.taxel_area_mm2 = type.pitch_mm * type.pitch_mm;
  return {key::described(key::number("taxel_area_mm2", type.taxel_area_mm2, {"mm²"}, {1e-4, 1e4},
                                     "Effective area of one taxel, for forces"),
                         "the square of pitch_mm"),
          key::number("orientation_deg", type.orientation_deg, {"°"}, {0.0, 360.0},
                      "Angle between row 0 and the bench's x axis"),
          key::span("output_range_v", type.output_low_v, type.output_high_v, {"V"},
                    "Lowest and highest voltage that the array can give"),
          key::required(key::word("full_scale", type.full_scale, {"highest mean output of the run"},
                                  "Definition of 100 % of full scale, for figures given as a share of it"))};
}

SensorType sensor_type_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  SensorType type;
  type.text = document.text();
  read_keys(root, type_keys(type));
  read_whole(root, geometry_keys(type));
  return type;
}

}  // namespace

SensorType read_sensor_type(const std::string& path, const std::vector<sequences::Override>& overrides) {
  TomlDocument document = TomlDocument::from_file(path);
  for (const sequences::Override& override_value : overrides) document.set(override_value);
  return sensor_type_of(document);
}

SensorType parse_sensor_type(const std::string& text, const std::string& name) {
  return sensor_type_of(TomlDocument::from_text(text, name));
}

namespace {

KeyTable rule_keys(analysis::Limits& limits) {
  return {key::schema(),
          key::name("name", limits.name, "Name of these limits; on reports"),
          key::word("rule", limits.rule, {"default", "simple", "guarded", "four-way", "report-only"},
                    "Decision rule (ILAC-G8:09/2019). simple: value <= limit; guarded: value <= limit - U; four-way: "
                    "pass, conditional pass, conditional fail, fail; report-only: no verdict; default: four-way if U "
                    "is known, else simple"),
          key::required(key::number("mean_compensation_error_psi", limits.mean_compensation_error_psi, {"psi"}, {},
                                    "Largest mean error |estimate - reference| over all fitted taxels and frames")),
          key::required(key::number("worst_taxel_error_psi", limits.worst_taxel_error_psi, {"psi"}, {},
                                    "Largest mean error of the worst taxel")),
          key::required(key::number("distance_of_mean_percent_fs", limits.distance_of_mean_fs, kPercentOfFullScale, {},
                                    "Largest mean distance of the array's mean pressure between rise and fall")),
          key::required(key::number("unfit_taxels", limits.unfit_taxels, kOne, {},
                                    "Largest number of dead, stuck, saturated or not modelled taxels"))};
}

KeyTable mismatch_keys(analysis::Limits::Mismatch& mismatch) {
  return {key::required(key::number("pressure_psi", mismatch.pressure_psi, {"psi"}, {},
                                    "Level at which the taxels are compared; it must be a level of the judged run")),
          key::required(key::number("std_percent_fs", mismatch.std_fs, kPercentOfFullScale, {},
                                    "Largest standard deviation of the compensated pressure over the taxels there"))};
}

KeyTable where_keys(analysis::Limits::Mpe& mpe) {
  return {key::optional(key::span("span_psi", mpe.low_psi, mpe.high_psi, {"psi"},
                                  "Lowest and highest pressure of the span to which it applies; or pressure_psi")),
          key::optional(key::number("pressure_psi", mpe.low_psi, {"psi"}, {},
                                    "Level to which the maximum permissible error applies; or span_psi"))};
}

KeyTable mpe_keys(analysis::Limits::Mpe& mpe) {
  return {
      key::required(key::number("mpe_psi", mpe.mpe_psi, {"psi"}, {},
                                "Maximum permissible error: |error| + U of one reading must stay within it")),
      key::number("taxels_percent", mpe.share, kPercent, {1.0, 100.0}, "Share of the taxels that must stay within it")};
}

analysis::Limits::Mpe mpe_of(const TomlTable& row) {
  analysis::Limits::Mpe mpe;
  const bool span = row.has("span_psi");
  if (span == row.has("pressure_psi"))
    row.fail(span ? "span_psi" : "pressure_psi",
             std::string("an [[mpe]] applies to one level or to a span, but it names ") + (span ? "both" : "neither"),
             "write pressure_psi = 20, or span_psi = [4, 60]");
  read_keys(row, where_keys(mpe));
  if (!span) mpe.high_psi = mpe.low_psi;
  read_keys(row, mpe_keys(mpe));
  if (!(mpe.mpe_psi > 0.0)) row.fail("mpe_psi", "a maximum permissible error must be above 0", "write mpe_psi = 2.0");
  row.finish();
  return mpe;
}

analysis::Limits limits_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  analysis::Limits limits;
  limits.toml = document.text();
  limits.sha256 = db::sha256_hex(limits.toml);
  read_keys(root, rule_keys(limits));
  for (const TomlTable& row : root.tables("mismatch")) {
    read_whole(row, mismatch_keys(limits.mismatch.emplace_back()));
  }
  for (const TomlTable& row : root.tables("mpe")) limits.mpe.push_back(mpe_of(row));
  root.finish();
  return limits;
}

}  // namespace

analysis::Limits read_limits(const std::string& path) { return limits_of(TomlDocument::from_file(path)); }
analysis::Limits parse_limits(const std::string& text, const std::string& name) {
  return limits_of(TomlDocument::from_text(text, name));
}

std::vector<sequences::KeyFacts> sensor_type_keys() {
  SensorType type;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", type_keys(type));
  add_facts(all, "", geometry_keys(type));
  return all;
}

std::vector<sequences::KeyFacts> limits_keys() {
  analysis::Limits limits;
  analysis::Limits::Mismatch mismatch;
  analysis::Limits::Mpe mpe;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", rule_keys(limits));
  add_facts(all, "mismatch[]", mismatch_keys(mismatch));
  add_facts(all, "mpe[]", where_keys(mpe));
  add_facts(all, "mpe[]", mpe_keys(mpe));
  return all;
}

}  // namespace tactbench::bench
