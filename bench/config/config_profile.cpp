#include "bench/config/config_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "bench/config/config.h"
#include "bench/config/config_modbus.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::Range;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

constexpr int kMostRegisters = 120;  // in one reading

// One of `known`.
Key function_key(const char* name, int& function, const std::vector<int>& known, const char* meaning) {
  return key::made(
      {name, "whole number", "1", fmt::format("{}", fmt::join(known, ", ")), fmt::format("`{}`", function), meaning},
      [name, &function, known](const TomlTable& table) {
        function = static_cast<int>(table.integer(name, function, 0, 127));
        if (std::find(known.begin(), known.end(), function) != known.end()) return;
        table.fail(name, fmt::format("function code {} cannot be used here", function),
                   fmt::format("one of: {}", fmt::join(known, ", ")));
      });
}

KeyTable scale_keys(devices::LinearScale& volts) {
  return {key::span("raw_span", volts.raw_low, volts.raw_high, {"counts"}, "Two values of the register ..."),
          key::span("volts_span", volts.low, volts.high, {"V"},
                    "... and the corresponding voltages; 0 V must be between them")};
}

void read_scale(const TomlTable& table, devices::LinearScale& volts) {
  read_keys(table, scale_keys(volts));
  if (volts.low > 0.0 || volts.high <= 0.0)
    table.fail("volts_span", "the span does not include 0 V", "give the counts of a span that begins at or below 0 V");
}

KeyTable output_keys(devices::ModuleOutputs& out) {
  return {function_key("function", out.function, {6, 16, 23},
                       "Modbus function that writes: 6 one register, 16 several, 23 several and reads the inputs"),
          key::number("address", out.address, kOne, {0, 65535},
                      "Register of output 0, counted from 0; one register per output"),
          key::required(key::number("channels", out.channels, kOne, {1, kMostRegisters}, "Number of outputs")),
          function_key("readback_function", out.readback, {0, 3, 4},
                       "Function that reads the outputs back after each write; 0: it cannot"),
          key::number("dead_band_counts", out.dead_band, {"counts"}, {0, 1000},
                      "Largest difference between the written and the read-back value"),
          key::number("deadline_ms", out.deadline, kMilliseconds, {1.0, 10000.0, true},
                      "Time after a write in which it may differ by more; 0: never")};
}

devices::ModuleOutputs read_outputs(const TomlTable& table) {
  devices::ModuleOutputs out;
  read_keys(table, output_keys(out));
  read_scale(table, out.volts);
  if (out.volts.raw_low < 0.0 || out.volts.raw_high > 65535.0) {
    table.fail("raw_span", "a register holds 0 to 65535 counts", "give the counts as in the register");
  }
  table.finish();
  return out;
}

KeyTable input_keys(devices::ModuleInputs& in) {
  constexpr int kMostInputs = kMostRegisters / 2;  // of two registers
  KeyTable keys = {function_key("function", in.function, {3, 4},
                                "Modbus function that reads: 3 holding registers, 4 input registers"),
                   key::number("address", in.address, kOne, {0, 65535}, "Register of input 0, counted from 0"),
                   key::required(key::number("channels", in.channels, kOne, {1, kMostInputs}, "Number of inputs")),
                   key::number("spare", in.spare, kOne, {0, 8},
                               "Readable registers after the last input; RTU readings then change length, which shows "
                               "a stale answer")};
  for (const Key& row : format_keys(in.format)) keys.push_back(row);
  keys.push_back(key::number("status_offset", in.status_offset, kOne, {-1, kMostInputs},
                             "Registers from address to the status words, one per input; -1: none"));
  return keys;
}

devices::ModuleInputs read_inputs(const TomlTable& table) {
  devices::ModuleInputs in;
  read_keys(table, input_keys(in));
  read_scale(table, in.volts);
  table.finish();
  return in;
}

KeyTable layer_keys(std::string& text) {
  return {key::required(
      key::text("text", text, "What the module does by itself when writes stop; printed before each run"))};
}

KeyTable fail_safe_keys(devices::ModuleFailSafe& safe) {
  constexpr Range kNoneOrAddress{-1, 65535};
  return {key::number("watchdog_address", safe.watchdog_address, kOne, kNoneOrAddress,
                      "First of the watchdog's registers, in Beckhoff's layout; -1: none"),
          key::number("fallbacks_address", safe.fallbacks_address, kOne, kNoneOrAddress,
                      "Register that counts how often the watchdog acted; -1: none"),
          key::number("safe_mode_address", safe.safe_mode_address, kOne, kNoneOrAddress,
                      "First of the discrete inputs that report an output's safe mode (Moxa); -1: none"),
          key::number("safe_mode_clear_address", safe.safe_mode_clear_address, kOne, kNoneOrAddress,
                      "First of the coils that end the safe mode (Moxa); -1: none")};
}

devices::ModuleFailSafe read_fail_safe(const TomlTable& table) {
  devices::ModuleFailSafe safe;
  for (const TomlTable& layer : table.tables("layer")) {
    read_whole(layer, layer_keys(safe.layers.emplace_back()));
  }
  read_whole(table, fail_safe_keys(safe));
  return safe;
}

enum class Transports { kTcp, kRtu, kAny };

KeyTable profile_keys(devices::ModuleProfile& profile, Transports& transports) {
  return {key::schema(),
          key::required(key::text("model", profile.model, "Maker and model, printed and stored with each run")),
          key::required(key::word("transport", transports, {"tcp", "rtu", "any"},
                                  "Which Modbus it speaks: over the network, over a serial line, or either")),
          key::number("max_reply_delay_ms", profile.max_reply_delay, kMilliseconds, {1.0, 60000.0},
                      "Longest delay of an answer on a serial line")};
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
  devices::ModuleProfile profile;
  profile.name = std::filesystem::path(name).stem().string();
  Transports transports = Transports::kTcp;
  read_keys(root, profile_keys(profile, transports));
  profile.tcp = transports != Transports::kRtu;
  profile.rtu = transports != Transports::kTcp;
  if (root.has("outputs")) profile.outputs = read_outputs(root.table("outputs"));
  if (root.has("inputs")) profile.inputs = read_inputs(root.table("inputs"));
  profile.fail_safe = read_fail_safe(root.table("fail_safe"));
  root.finish();
  if (profile.outputs.function == 23 && profile.inputs.channels == 0) {
    root.fail("outputs", "function 23 reads inputs, but the profile has none", "use function 6 or 16");
  }
  return profile;
}

std::vector<sequences::KeyFacts> module_profile_keys() {
  devices::ModuleProfile profile;
  Transports transports = Transports::kTcp;
  std::string text;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", profile_keys(profile, transports));
  add_facts(all, "outputs", output_keys(profile.outputs));
  add_facts(all, "outputs", scale_keys(profile.outputs.volts));
  add_facts(all, "inputs", input_keys(profile.inputs));
  add_facts(all, "inputs", scale_keys(profile.inputs.volts));
  add_facts(all, "fail_safe.layer[]", layer_keys(text));
  add_facts(all, "fail_safe", fail_safe_keys(profile.fail_safe));
  return all;
}

}  // namespace tactbench::bench
