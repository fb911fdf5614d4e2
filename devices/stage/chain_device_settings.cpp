// The settings of a simulated T-Series device: which error refuses which value, and the effects of a change.
#include <bit>
#include <cmath>

#include "devices/stage/chain_device.h"

namespace tactbench::devices {

std::int32_t ChainDevice::error_of_setting(ZaberCommand command, std::int32_t data, Nanoseconds now) const {
  using enum ZaberCommand;
  const auto own = static_cast<std::int32_t>(command);  // for most settings the error is the setting's number
  const std::int32_t highest_speed = 512 * setting(kResolution) - 1;
  const auto within = [&](std::int64_t low, std::int64_t high) { return data >= low && data <= high ? 0 : own; };
  if (setting(kLock) != 0 && command != kLock) return 3600;
  switch (command) {
    case kResolution:
      if (under_way_) return kZaberBusy;
      return data >= 1 && data <= 128 && std::has_single_bit(static_cast<unsigned>(data)) ? 0 : own;
    case kRunningCurrent:
    case kHoldCurrent:
      return data == 0 ? 0 : within(10, 127);
    case kMode:
      for (const int reserved : {8, 10, 13}) {
        if ((data >> reserved & 1) != 0) return 4000 + reserved;
      }
      return within(0, 0xFFFF);
    case kHomeSpeed:
    case kTargetSpeed:
    case kAcceleration:
      return within(0, highest_speed);
    case kMaximumPosition:
      // Firmware 5.21 and 5.22 refuse a maximum below the present position.
      if (options_.firmware < 523 && data < counter(now)) return own;
      return within(0, 16777215);
    case kMaximumRelativeMove:
      return within(0, 16777215);
    case kSetPosition:
    case kHomeOffset:
      return within(0, setting(kMaximumPosition));
    case kAlias:
      return within(0, 254);
    case kLock:
      return within(0, 1);
    default:
      return 64;
  }
}

void ChainDevice::change_setting(ZaberCommand command, std::int32_t data, Nanoseconds now) {
  using enum ZaberCommand;
  if (command == kSetPosition) {
    zero_ = std::round(believed(now)) - data;
    settings_[kMode] |= kZaberHomed;
    return;
  }
  if (command == kResolution) {
    const double finer = static_cast<double>(data) / setting(kResolution);
    remember(now);
    motion_.profile = MotionProfile(std::round(motion_.profile.end() * finer));
    motion_.began = now;
    motion_.mm_per_step = full_step_mm_ / data;
    motion_.slipped *= finer;
    if (motion_.stuck) *motion_.stuck *= finer;
    zero_ = std::round(zero_ * finer);
  }
  settings_[command] = data;
}

// [M] Byte 3: bit 7 writes, the rest is the address; byte 4 is the value.
std::int32_t ChainDevice::memory(std::int32_t data) {
  auto& cell = memory_[static_cast<std::size_t>(data & 0x7F)];
  if ((data & 0x80) != 0) cell = data >> 8 & 0xFF;
  return (data & 0x7F) | cell << 8;
}

}  // namespace tactbench::devices
