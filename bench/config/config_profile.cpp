#include "bench/config/config_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "bench/common/process_time.h"
#include "bench/config/config.h"
#include "bench/config/config_modbus.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

using sequences::TomlTable;

namespace {

constexpr int kMostRegisters = 120;  // in one reading

int address(const TomlTable& table, const std::string& key, long fallback, long low) {
  return static_cast<int>(table.integer(key, fallback, low, 65535));
}

int function_of(const TomlTable& table, const std::string& key, int fallback, const std::vector<int>& known) {
  const int value = static_cast<int>(table.integer(key, fallback, 0, 127));
  if (std::find(known.begin(), known.end(), value) == known.end()) {
    table.fail(key, fmt::format("function code {} cannot be used here", value),
               fmt::format("one of: {}", fmt::join(known, ", ")));
  }
  return value;
}

devices::LinearScale volts_scale(const TomlTable& table) {
  const auto raw = table.span("raw_span", {0.0, 32767.0});
  const auto volts = table.span("volts_span", {0.0, 10.0});
  if (volts.first > 0.0 || volts.second <= 0.0) {
    table.fail("volts_span", "the span does not hold 0 V", "give the counts of a span that begins at or below 0 V");
  }
  return {raw.first, raw.second, volts.first, volts.second};
}

devices::ModuleOutputs read_outputs(const TomlTable& table) {
  devices::ModuleOutputs out;
  out.function = function_of(table, "function", 16, {6, 16, 23});
  out.address = address(table, "address", 0, 0);
  out.channels = static_cast<int>(table.integer("channels", 1, kMostRegisters));
  out.readback = function_of(table, "readback_function", 3, {0, 3, 4});
  out.dead_band = static_cast<int>(table.integer("dead_band_counts", 0, 0, 1000));
  out.deadline = seconds(table.zero_or_in("deadline_ms", 0.0, 1.0, 10000.0) / 1000.0);
  out.volts = volts_scale(table);
  if (out.volts.raw_low < 0.0 || out.volts.raw_high > 65535.0) {
    table.fail("raw_span", "a register holds 0 to 65535 counts", "give the counts as in the register");
  }
  table.finish();
  return out;
}

devices::ModuleInputs read_inputs(const TomlTable& table) {
  devices::ModuleInputs in;
  in.function = function_of(table, "function", 4, {3, 4});
  in.address = address(table, "address", 0, 0);
  in.channels = static_cast<int>(table.integer("channels", 1, kMostRegisters / 2));
  in.spare = static_cast<int>(table.integer("spare", 0, 0, 8));
  in.format = read_format(table, "i16");
  in.status_offset = static_cast<int>(table.integer("status_offset", -1, -1, kMostRegisters / 2));
  in.volts = volts_scale(table);
  table.finish();
  return in;
}

devices::ModuleFailSafe read_fail_safe(const TomlTable& table) {
  devices::ModuleFailSafe safe;
  for (const TomlTable& layer : table.tables("layer")) {
    safe.layers.push_back(layer.text("text"));
    layer.finish();
  }
  safe.watchdog_address = address(table, "watchdog_address", -1, -1);
  safe.fallbacks_address = address(table, "fallbacks_address", -1, -1);
  safe.safe_mode_address = address(table, "safe_mode_address", -1, -1);
  safe.safe_mode_clear_address = address(table, "safe_mode_clear_address", -1, -1);
  table.finish();
  return safe;
}

std::string profile_folder() { return share_folder() + "/devices/profiles"; }

std::string find_profile(const std::string& name) {
  std::string shipped = fmt::format("{}/{}.toml", profile_folder(), name);
  std::error_code unusable;  // an invalid name counts as a missing file
  if (name.find('/') == std::string::npos && std::filesystem::is_regular_file(shipped, unusable)) return shipped;
  if (std::filesystem::is_regular_file(name, unusable)) return name;
  const auto known = shipped_profiles();
  const std::string near = sequences::nearest_word(name, known);
  throw sequences::FileError("TB-MODULE-PROFILE", fmt::format("no module profile is named '{}'", name),
                             "[module] profile",
                             (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) +
                                 fmt::format("shipped: {}; or give the path of a file like {}/generic.toml",
                                             fmt::join(known, ", "), profile_folder()));
}

}  // namespace

std::vector<std::string> shipped_profiles() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(profile_folder(), ignored)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

devices::ModuleProfile read_module_profile(const std::string& name) {
  const sequences::TomlDocument document = sequences::TomlDocument::from_file(find_profile(name));
  const TomlTable root = document.root();
  (void)root.integer("schema", 1, 1);
  devices::ModuleProfile profile;
  profile.name = std::filesystem::path(name).stem().string();
  profile.model = root.text("model");
  const std::string transport = root.word("transport", {"tcp", "rtu", "any"});
  profile.tcp = transport != "rtu";
  profile.rtu = transport != "tcp";
  profile.max_reply_delay = seconds(root.number_in("max_reply_delay_ms", 1000.0, 1.0, 60000.0) / 1000.0);
  if (root.has("outputs")) profile.outputs = read_outputs(root.table("outputs"));
  if (root.has("inputs")) profile.inputs = read_inputs(root.table("inputs"));
  profile.fail_safe = read_fail_safe(root.table("fail_safe"));
  root.finish();
  if (profile.outputs.function == 23 && profile.inputs.channels == 0) {
    root.fail("outputs", "function 23 reads inputs, and the profile has none", "use function 6 or 16");
  }
  return profile;
}

}  // namespace tactbench::bench
