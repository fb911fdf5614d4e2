// The fail-safe side of AnalogModule: watchdog and safe mode, set up and verified by reading.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "devices/pressure/analog_module.h"

namespace tactbench::devices {
namespace {

// Offsets from the EK9000's watchdog time register (0x1120).
constexpr int kResetRegister = 1;
constexpr int kTypeRegister = 2;
constexpr int kWriteLockRegister = 4;
constexpr std::uint16_t kFedByWrites = 0;
constexpr std::array<std::uint16_t, 2> kResetWords{0xBECF, 0xAFFE};

constexpr const char* kFailSafeDevice = "analog module";

}  // namespace

void AnalogModule::bring_up() {
  if (profile_.fail_safe.watchdog_address >= 0 || watchdog_ != Nanoseconds(0)) set_watchdog();
  if (profile_.fail_safe.safe_mode_address >= 0) clear_safe_mode();
  outputs_ = rest_;
  last_write_time_ = Nanoseconds(-1);
  dump_closed_ = false;
  close_dump();
  refresh();
}

void AnalogModule::set_watchdog() {
  const ModuleFailSafe& safe = profile_.fail_safe;
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(watchdog_).count();
  if (safe.watchdog_address < 0 || milliseconds < 1 || milliseconds > 60'000) {
    throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
                fmt::format("a watchdog of {} ms was requested of {}, which {}", milliseconds, link_.peer(),
                            safe.watchdog_address < 0 ? "has none" : "takes 1 to 60000 ms"),
                "Correct the watchdog time in the bench file, or choose a module with a watchdog.");
  }
  for (const std::uint16_t word : kResetWords) {
    link_.write_registers(safe.watchdog_address + kResetRegister, std::span(&word, 1));
  }
  set_register(safe.watchdog_address + kWriteLockRegister, 0);
  set_register(safe.watchdog_address + kTypeRegister, kFedByWrites);
  set_register(safe.watchdog_address, static_cast<std::uint16_t>(milliseconds));
  fallbacks_at_start_ = fallbacks();
}

void AnalogModule::set_register(int address, std::uint16_t value) {
  link_.write_registers(address, std::span(&value, 1));
  std::uint16_t stands = 0;
  link_.read_holding_registers(address, std::span(&stands, 1));
  if (stands == value) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("setting watchdog register 0x{:04X} of {} to {}: it reads back {}", address, link_.peer(),
                          value, stands),
              "Check that the profile in the bench file fits the module and that no other master sets it.");
}

void AnalogModule::clear_safe_mode() {
  const ModuleFailSafe& safe = profile_.fail_safe;
  const auto in_safe_mode = [&] {
    const auto channels = link_.read_discrete_inputs(safe.safe_mode_address, profile_.outputs.channels);
    return std::find(channels.begin(), channels.end(), true) != channels.end();
  };
  if (!in_safe_mode()) return;
  for (int i = 0; i < profile_.outputs.channels; ++i) link_.write_coil(safe.safe_mode_clear_address + i, true);
  if (!in_safe_mode()) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("{} stays in its safe mode when ordered to leave it", link_.peer()),
              "Check the module's own page for the cause (host connection watchdog), then start again.");
}

std::uint16_t AnalogModule::fallbacks() {
  std::uint16_t count = 0;
  const int address = profile_.fail_safe.fallbacks_address;
  if (address >= 0) link_.read_holding_registers(address, std::span(&count, 1));
  return count;
}

// Throws TB-MODULE-WATCHDOG instead of `fault` when the watchdog has fallen back since the start.
void AnalogModule::blame_watchdog(const Fault& fault, Nanoseconds time) {
  const bool possible = fault.id() == "TB-MODBUS-EXCEPTION" || fault.id() == "TB-MODULE-READBACK";
  if (!possible || fallbacks() == fallbacks_at_start_) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("{}; its watchdog ({:g} ms) has fallen back since the start, the last write is {:g} ms old",
                          fault.what(), in_milliseconds(watchdog_), in_milliseconds(time - last_write_time_)),
              "The outputs are at zero. Find out why the set-point was not rewritten in time, then start again.");
}

}  // namespace tactbench::devices
