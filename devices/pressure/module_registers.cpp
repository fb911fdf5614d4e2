#include "devices/pressure/module_registers.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactbench::devices {
namespace {

constexpr std::size_t kTime = 0;
constexpr std::size_t kReset = 1;
constexpr std::size_t kType = 2;
constexpr std::size_t kFallback = 3;
constexpr std::size_t kWriteLock = 4;
constexpr std::uint16_t kFedByAny = 1;
constexpr std::uint16_t kOff = 2;
constexpr std::uint16_t kFallToZero = 0;
constexpr std::uint16_t kFreeze = 1;
constexpr int kStatusOffset = -0x100;  // 0x1020 from 0x1120
constexpr int kStatusWords = 3;

bool inside(int address, std::size_t count, int from, int words) {
  return address >= from && static_cast<long>(address) + static_cast<long>(count) <= static_cast<long>(from) + words;
}

}  // namespace

ModuleRegisters::ModuleRegisters(ModuleProfile profile, ChamberPort& chamber, const Clock& clock)
    : profile_(std::move(profile)),
      chamber_(chamber),
      clock_(clock),
      outputs_(static_cast<std::size_t>(profile_.outputs)) {}

void ModuleRegisters::turn() {
  if (!armed_ || settings_[kType] == kOff || clock_.now() < deadline_) return;
  // The port was told at the last write when and to what it falls; here only the registers follow.
  armed_ = false;
  tripped_ = true;
  ++fallbacks_;
  if (settings_[kFallback] == kFallToZero) std::fill(outputs_.begin(), outputs_.end(), std::uint16_t{0});
}

bool ModuleRegisters::outputs_hold(int address, std::size_t count) const {
  return inside(address, count, profile_.output_address, profile_.outputs);
}

Refusal ModuleRegisters::check_read(int function, int address, std::size_t count) const {
  const int settings = profile_.watchdog_address;
  const bool holds =
      inside(address, count, profile_.input_address, profile_.inputs) ||
      (function == 3 && (outputs_hold(address, count) ||
                         (settings >= 0 && (inside(address, count, settings, 5) ||
                                            inside(address, count, settings + kStatusOffset, kStatusWords)))));
  return holds ? Refusal::kNone : Refusal::kAddress;
}

Refusal ModuleRegisters::read(int client, int function, int address, std::span<std::uint16_t> into) {
  const Refusal refusal = check_read(function, address, into.size());
  if (refusal != Refusal::kNone) return refusal;
  const bool process_data =
      inside(address, into.size(), profile_.input_address, profile_.inputs) || outputs_hold(address, into.size());
  if (process_data && client == master_) feed(false);
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = read_one(address + static_cast<int>(i));
  return Refusal::kNone;
}

std::uint16_t ModuleRegisters::read_one(int address) {
  if (inside(address, 1, profile_.input_address, profile_.inputs)) {
    const int channel = address - profile_.input_address;
    if (channel > 1) return 0;
    const Volts volts = channel == 0 ? chamber_.feedback() : chamber_.reference();
    const double full = profile_.raw_full_scale;
    const double counts = std::clamp(volts / profile_.volts_full_scale * full, -full - 1.0, full);
    return static_cast<std::uint16_t>(std::lround(counts));
  }
  if (outputs_hold(address, 1)) return outputs_[static_cast<std::size_t>(address - profile_.output_address)];
  if (address >= profile_.watchdog_address)
    return settings_[static_cast<std::size_t>(address - profile_.watchdog_address)];
  switch (address - profile_.watchdog_address - kStatusOffset) {
    case 0: {
      if (!armed_ || settings_[kType] == kOff) return 0;
      return static_cast<std::uint16_t>(
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - clock_.now()).count());
    }
    case 1:
      return fallbacks_;
    default:
      return static_cast<std::uint16_t>(connections_);
  }
}

Refusal ModuleRegisters::write(int client, int address, std::span<const std::uint16_t> values) {
  if (outputs_hold(address, values.size())) {
    const bool locked = settings_[kWriteLock] == 1 && master_ != kNobody && master_ != client;
    if (tripped_ || locked) return Refusal::kFailure;
    if (master_ == kNobody) master_ = client;
    std::copy(values.begin(), values.end(), outputs_.begin() + (address - profile_.output_address));
    const bool first = !std::exchange(armed_, true);
    if (client == master_ || first) {
      feed(true);
    } else {
      drive();
    }
    return Refusal::kNone;
  }
  const int settings = profile_.watchdog_address;
  if (settings < 0 || !inside(address, values.size(), settings, 5)) return Refusal::kAddress;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Refusal refusal = write_setting(address - settings + static_cast<int>(i), values[i]);
    if (refusal != Refusal::kNone) return refusal;
  }
  return Refusal::kNone;
}

Refusal ModuleRegisters::write_setting(int offset, std::uint16_t value) {
  const auto which = static_cast<std::size_t>(offset);
  if (which == kReset) {
    if (reset_begun_ && value == 0xAFFE) tripped_ = false;
    reset_begun_ = value == 0xBECF;
    return Refusal::kNone;
  }
  const std::uint16_t most = which == kTime ? 60'000 : which == kType ? kOff : which == kFallback ? kFreeze : 1;
  if (value > most || (which == kTime && value == 0)) return Refusal::kValue;
  settings_[which] = value;
  if (armed_ && which != kWriteLock) {  // a changed watchdog starts its time anew
    deadline_ = clock_.now() + std::chrono::milliseconds(settings_[kTime]);
    drive();
  }
  return Refusal::kNone;
}

void ModuleRegisters::feed(bool by_write) {
  if (!armed_ || (!by_write && settings_[kType] != kFedByAny)) return;
  deadline_ = clock_.now() + std::chrono::milliseconds(settings_[kTime]);
  drive();
}

void ModuleRegisters::drive() {
  // A unipolar output terminal clips negative words to zero.
  const auto counts = std::max<std::int16_t>(0, static_cast<std::int16_t>(outputs_[0]));
  const Volts volts = profile_.volts_full_scale * (static_cast<double>(counts) / profile_.raw_full_scale);
  const bool off = settings_[kType] == kOff;
  chamber_.drive(volts, off ? Nanoseconds::max() : deadline_, settings_[kFallback] == kFreeze ? volts : Volts(0.0));
}

void ModuleRegisters::disconnected(int client) {
  --connections_;
  if (master_ == client) master_ = kNobody;
}

}  // namespace tactbench::devices
