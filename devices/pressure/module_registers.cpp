#include "devices/pressure/module_registers.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactbench::devices {
namespace {

constexpr std::size_t kTime = 0;
constexpr std::size_t kWatchdogReset = 1;
constexpr std::size_t kWatchdogType = 2;
constexpr std::size_t kFallback = 3;
constexpr std::size_t kWatchdogWriteLock = 4;
constexpr std::uint16_t kFedByAny = 1;
constexpr std::uint16_t kOff = 2;
constexpr std::uint16_t kFallToZero = 0;
constexpr std::uint16_t kFreeze = 1;
constexpr int kStatusOffset = -0x100;  // 0x1020 from 0x1120
constexpr int kStatusWords = 3;

bool inside(int address, std::size_t count, int from, int words) {
  return address >= from && static_cast<long>(address) + static_cast<long>(count) <= static_cast<long>(from) + words;
}

std::uint16_t zero_counts(const ModuleOutputs& out) {
  return static_cast<std::uint16_t>(std::lround(std::max(0.0, out.volts.raw(0.0))));
}

}  // namespace

ModuleRegisters::ModuleRegisters(SimulatedUnit unit, ChamberPort& chamber, const Clock& clock)
    : unit_(std::move(unit)),
      out_(unit_.profile.outputs),
      in_(unit_.profile.inputs),
      watchdog_at_(unit_.profile.fail_safe.watchdog_address),
      chamber_(chamber),
      clock_(clock),
      outputs_(static_cast<std::size_t>(out_.channels), zero_counts(out_)),
      safe_mode_(outputs_.size(), unit_.starts_in_safe_mode ? 1 : 0) {
  if (unit_.profile.dump_coil >= 0) chamber_.dump(true);
}

void ModuleRegisters::turn() {
  if (watchdog_at_ < 0 || !armed_ || settings_[kWatchdogType] == kOff || clock_.now() < deadline_) return;
  // The last write already gave the port time and value of the fallback; here only the registers follow.
  armed_ = false;
  tripped_ = true;
  ++fallbacks_;
  if (settings_[kFallback] != kFallToZero) return;
  std::fill(outputs_.begin(), outputs_.end(), zero_counts(out_));
  if (unit_.profile.dump_coil >= 0) chamber_.dump(true);  // late, at the next request: the port takes no time
}

bool ModuleRegisters::outputs_hold(int address, std::size_t count) const {
  return inside(address, count, out_.address, out_.channels);
}

bool ModuleRegisters::inputs_hold(int address, std::size_t count) const {
  const int values = in_.channels * static_cast<int>(in_.format.words());
  const int status = in_.status_offset < 0 || in_.channels == 0 ? 0 : in_.status_offset + in_.channels;
  return inside(address, count, in_.address, std::max(values, status) + in_.spare);
}

const SimulatedQuantity* ModuleRegisters::quantity_at(int function, int address, std::size_t count) const {
  for (const SimulatedQuantity& quantity : unit_.quantities) {
    const int words = static_cast<int>(quantity.at.format.words()) + quantity.at.spare;
    if (quantity.at.function == function && inside(address, count, quantity.at.address, words)) return &quantity;
  }
  return nullptr;
}

Refusal ModuleRegisters::check_read(int function, int address, std::size_t count) const {
  const bool holds =
      inputs_hold(address, count) || quantity_at(function, address, count) != nullptr ||
      (function == 3 && (outputs_hold(address, count) ||
                         (watchdog_at_ >= 0 && (inside(address, count, watchdog_at_, 5) ||
                                                inside(address, count, watchdog_at_ + kStatusOffset, kStatusWords)))));
  return holds ? Refusal::kNone : Refusal::kAddress;
}

Refusal ModuleRegisters::read(int client, int function, int address, std::span<std::uint16_t> into) {
  const Refusal refusal = check_read(function, address, into.size());
  if (refusal != Refusal::kNone) return refusal;
  const bool process_data = inputs_hold(address, into.size()) || outputs_hold(address, into.size());
  if (process_data && client == master_) feed(false);
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = read_one(function, address + static_cast<int>(i));
  return Refusal::kNone;
}

std::uint16_t ModuleRegisters::read_one(int function, int address) {
  // ADAM's input block contains the outputs in its middle.
  if (function == 3 && outputs_hold(address, 1)) return outputs_[static_cast<std::size_t>(address - out_.address)];
  if (inputs_hold(address, 1)) return read_input(address - in_.address);
  if (const SimulatedQuantity* quantity = quantity_at(function, address, 1)) {
    const auto words = encode_register(quantity->at.format, quantity->at.scale.raw(quantity->read()));
    const auto offset = static_cast<std::size_t>(address - quantity->at.address);
    return offset < words.size() ? words[offset] : std::uint16_t{0};
  }
  if (address >= watchdog_at_) return settings_[static_cast<std::size_t>(address - watchdog_at_)];
  switch (address - watchdog_at_ - kStatusOffset) {
    case 0: {
      if (!armed_ || settings_[kWatchdogType] == kOff) return 0;
      return static_cast<std::uint16_t>(
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - clock_.now()).count());
    }
    case 1:
      return fallbacks_;
    default:
      return static_cast<std::uint16_t>(connections_);
  }
}

// The regulator's monitor and the transducer are each wired to one channel; the others are open.
std::uint16_t ModuleRegisters::read_input(int offset) {
  const int words = static_cast<int>(in_.format.words());
  const int channel = offset / words;
  if (channel >= in_.channels || (channel != unit_.feedback_channel && channel != unit_.reference_channel)) return 0;
  const Volts volts = channel == unit_.feedback_channel ? chamber_.feedback() : chamber_.reference();
  const double span = in_.volts.raw_high - in_.volts.raw_low;
  const double raw = std::clamp(in_.volts.raw(volts.value()), in_.volts.raw_low - span - 1.0, in_.volts.raw_high);
  return encode_register(in_.format, raw)[static_cast<std::size_t>(offset % words)];
}

Refusal ModuleRegisters::read_bits(int address, std::span<std::uint8_t> into) const {
  const int at = unit_.profile.fail_safe.safe_mode_address;
  if (at < 0 || !inside(address, into.size(), at, out_.channels)) return Refusal::kAddress;
  std::copy_n(safe_mode_.begin() + (address - at), into.size(), into.begin());
  return Refusal::kNone;
}

Refusal ModuleRegisters::write_bit(int address, bool value) {
  if (address == unit_.profile.dump_coil) {
    if (tripped_) return Refusal::kFailure;
    chamber_.dump(!value);
    return Refusal::kNone;
  }
  const int at = unit_.profile.fail_safe.safe_mode_clear_address;
  if (at < 0 || !inside(address, 1, at, out_.channels)) return Refusal::kAddress;
  if (value) safe_mode_[static_cast<std::size_t>(address - at)] = 0;
  return Refusal::kNone;
}

Refusal ModuleRegisters::write(int client, int address, std::span<const std::uint16_t> values) {
  if (outputs_hold(address, values.size())) {
    const bool locked = settings_[kWatchdogWriteLock] == 1 && master_ != kNobody && master_ != client;
    if (tripped_ || locked) return Refusal::kFailure;
    if (master_ == kNobody) master_ = client;
    const auto first_channel = static_cast<std::size_t>(address - out_.address);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (safe_mode_[first_channel + i] == 0) outputs_[first_channel + i] = values[i];
    }
    const bool first = !std::exchange(armed_, true);
    if (client == master_ || first) {
      feed(true);
    } else {
      drive();
    }
    return Refusal::kNone;
  }
  const int settings = watchdog_at_;
  if (settings < 0 || !inside(address, values.size(), settings, 5)) return Refusal::kAddress;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Refusal refusal = write_setting(address - settings + static_cast<int>(i), values[i]);
    if (refusal != Refusal::kNone) return refusal;
  }
  return Refusal::kNone;
}

Refusal ModuleRegisters::write_setting(int offset, std::uint16_t value) {
  const auto which = static_cast<std::size_t>(offset);
  if (which == kWatchdogReset) {
    if (reset_begun_ && value == 0xAFFE) tripped_ = false;
    reset_begun_ = value == 0xBECF;
    return Refusal::kNone;
  }
  const std::uint16_t most = which == kTime ? 60'000 : which == kWatchdogType ? kOff : which == kFallback ? kFreeze : 1;
  if (value > most || (which == kTime && value == 0)) return Refusal::kValue;
  settings_[which] = value;
  if (armed_ && which != kWatchdogWriteLock) {  // a changed watchdog restarts its time
    deadline_ = clock_.now() + std::chrono::milliseconds(settings_[kTime]);
    drive();
  }
  return Refusal::kNone;
}

void ModuleRegisters::feed(bool by_write) {
  if (!armed_ || (!by_write && settings_[kWatchdogType] != kFedByAny)) return;
  deadline_ = clock_.now() + std::chrono::milliseconds(settings_[kTime]);
  drive();
}

void ModuleRegisters::drive() {
  if (outputs_.empty()) return;
  const std::uint16_t counts = outputs_[static_cast<std::size_t>(unit_.output_channel)];
  // Where 15 bits are the full scale (a unipolar output terminal), a negative word is clipped to 0 V.
  const bool negative = out_.volts.raw_low >= 0.0 && out_.volts.raw_high <= 0x7FFF && (counts & 0x8000U) != 0;
  const Volts volts(negative ? 0.0 : out_.volts.physical(counts));
  const bool off = watchdog_at_ < 0 || settings_[kWatchdogType] == kOff;
  chamber_.drive(volts, off ? Nanoseconds::max() : deadline_, settings_[kFallback] == kFreeze ? volts : Volts(0.0));
}

void ModuleRegisters::disconnected(int client) {
  --connections_;
  if (master_ == client) master_ = kNobody;
}

}  // namespace tactbench::devices
