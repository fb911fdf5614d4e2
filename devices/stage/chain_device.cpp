#include "devices/stage/chain_device.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace tactbench::devices {
namespace {

using enum ZaberCommand;

constexpr Nanoseconds kTracking = std::chrono::milliseconds(250);
constexpr std::size_t kRemembered = 256;
constexpr double kDeviceSpeedUnit = 9.375;
constexpr double kDeviceAccelerationUnit = 11250.0;

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

Nanoseconds after(Nanoseconds begin, double span) {
  return begin + std::chrono::ceil<Nanoseconds>(std::chrono::duration<double>(span));
}

bool answered_without_auto_reply(ZaberCommand command) {
  const bool asks = command >= kDeviceId && command <= kEcho;
  return asks || command == kPosition || command == kRenumber || command == kReturnStoredPosition || command == kError;
}

}  // namespace

ChainDevice::ChainDevice(const ChainDeviceOptions& options) : options_(options), number_(options.number) {
  const ZaberModel* model = zaber_model(options.device_id);
  if (model == nullptr) model = zaber_model(60);
  full_step_mm_ = model->full_step_mm;
  const double microstep = full_step_mm_ / 64;
  settings_ = {{kResolution, 64},
               {kRunningCurrent, 10},
               {kHoldCurrent, 20},
               {kMode, options.mode},
               {kHomeSpeed, options.home_speed},
               {kTargetSpeed, options.target_speed},
               {kAcceleration, options.acceleration},
               {kMaximumPosition, static_cast<std::int32_t>(model->travel.value() / microstep)},
               {kMaximumRelativeMove, static_cast<std::int32_t>(model->travel.value() / microstep)},
               {kHomeOffset, 0},
               {kAlias, 0},
               {kLock, 0}};
  motion_ = {MotionProfile(std::round(options.stands_at.value() / microstep)), Nanoseconds(0), microstep, 0.0,
             std::nullopt};
  power_up();
}

// The counter starts at 0 at any position of the device; home status is lost, settings are kept.
void ChainDevice::power_up() {
  settings_[kMode] &= ~kZaberHomed;
  zero_ = motion_.profile.end();
}

bool ChainDevice::hears(std::uint8_t device) const {
  return device == 0 || device == number_ || device == setting(kAlias);
}

double ChainDevice::believed(Nanoseconds now) const { return motion_.profile.position(seconds(now - motion_.began)); }
double ChainDevice::velocity(Nanoseconds now) const { return motion_.profile.velocity(seconds(now - motion_.began)); }

double ChainDevice::Motion::true_steps(Nanoseconds time) const {
  return stuck ? *stuck : profile.position(seconds(time - began)) - slipped;
}

void ChainDevice::remember(Nanoseconds now) {
  if (past_.size() == kRemembered) past_.pop_front();
  past_.emplace_back(now, motion_);
}

void ChainDevice::stick(Nanoseconds now) {
  remember(now);
  motion_.stuck = motion_.true_steps(now);
}

void ChainDevice::free(Nanoseconds now) {
  if (!motion_.stuck) return;
  remember(now);
  motion_.slipped = believed(now) - *std::exchange(motion_.stuck, std::nullopt);
  // It has not reached its home sensor yet and continues toward it.
  if (under_way_ && under_way_->command == kHome) go_home(ZaberFrame(*under_way_), velocity(now), now);
}

std::int32_t ChainDevice::counter(Nanoseconds now) const {
  return static_cast<std::int32_t>(std::lround(believed(now) - zero_));
}

Millimetres ChainDevice::position(Nanoseconds time) const {
  const auto then = std::find_if(past_.begin(), past_.end(), [&](const auto& each) { return time < each.first; });
  const Motion& motion = then == past_.end() ? motion_ : then->second;
  return Millimetres(motion.true_steps(time) * motion.mm_per_step);
}

bool ChainDevice::at_rest_since(Nanoseconds time) const {
  const bool before = past_.empty() || time >= past_.back().first;
  return before && (motion_.stuck || time >= after(motion_.began, motion_.profile.duration()));
}

void ChainDevice::say(ZaberCommand command, std::int32_t data, std::uint8_t id,
                      std::vector<ZaberFrame>& replies) const {
  if ((setting(kMode) & kZaberNoAutoReply) != 0 && !answered_without_auto_reply(command)) return;
  replies.push_back({number_, command, data, id});
}

std::optional<Nanoseconds> ChainDevice::due() const {
  if (!under_way_) return std::nullopt;
  const Nanoseconds end = after(motion_.began, motion_.profile.duration());
  return (setting(kMode) & kZaberMoveTracking) != 0 ? std::min(end, next_tracking_) : end;
}

void ChainDevice::run(Nanoseconds now, std::vector<ZaberFrame>& replies) {
  if (!under_way_) return;
  const Nanoseconds end = after(motion_.began, motion_.profile.duration());
  if ((setting(kMode) & kZaberMoveTracking) != 0) {
    for (; next_tracking_ <= std::min(now, end); next_tracking_ += kTracking) {
      say(kMoveTracking, counter(next_tracking_), 0, replies);
    }
  }
  if (now < end) return;
  if (under_way_->command == kHome && motion_.stuck) return;  // it never reaches its home sensor
  const ZaberFrame done = *std::exchange(under_way_, std::nullopt);
  if (done.command == kHome) {
    zero_ = motion_.profile.end();
    settings_[kMode] |= kZaberHomed;
  }
  if (done.command == kConstantSpeed) {
    say(kLimitActive, counter(now), 0, replies);
  } else {
    say(done.command, counter(now), done.id, replies);
  }
}

void ChainDevice::begin(const ZaberFrame& frame, MotionProfile profile, Nanoseconds now) {
  remember(now);
  motion_.profile = std::move(profile);
  motion_.began = now;
  next_tracking_ = now + kTracking;
  under_way_ = frame;
}

void ChainDevice::reset(Nanoseconds now) {
  begin(ZaberFrame(), MotionProfile(believed(now)), now);
  under_way_.reset();
  power_up();
}

std::int32_t ChainDevice::error_of_move(const ZaberFrame& frame, Nanoseconds now) const {
  const bool homing = under_way_ && under_way_->command == kHome;
  if (homing && (frame.command != kStop || options_.refuses_stop_while_homing)) return kZaberBusy;
  const std::int64_t highest = setting(kMaximumPosition);
  const std::int64_t target = frame.data + (frame.command == kMoveRelative ? counter(now) : 0);
  switch (frame.command) {
    case kMoveAbsolute:
      return target < 0 || target > highest ? 20 : 0;
    case kMoveRelative:
      if (std::abs(frame.data) > setting(kMaximumRelativeMove)) return 2146;
      return target < 0 || target > highest ? 21 : 0;
    case kConstantSpeed:
      return std::abs(frame.data) > 512 * setting(kResolution) - 1 ? 22 : 0;
    case kMoveToStoredPosition:
      if (frame.data < 0 || frame.data >= static_cast<std::int32_t>(stored_.size())) return 1800;
      if ((setting(kMode) & kZaberHomed) == 0) return 1801;
      return stored_[static_cast<std::size_t>(frame.data)] > highest ? 18 : 0;
    default:
      return 0;
  }
}

double ChainDevice::acceleration() const {
  const int data = setting(kAcceleration) == 0 ? 512 * setting(kResolution) - 1 : setting(kAcceleration);
  return data * kDeviceAccelerationUnit;
}

void ChainDevice::go_home(const ZaberFrame& frame, double pace, Nanoseconds now) {
  const double speed = kDeviceSpeedUnit * std::max(setting(kHomeSpeed), 1);
  const double home = setting(kHomeOffset) + motion_.slipped;
  begin(frame, MotionProfile::to(believed(now), pace, home, speed, acceleration()), now);
}

void ChainDevice::move(const ZaberFrame& frame, Nanoseconds now) {
  const double place = believed(now);
  const double pace = velocity(now);
  const double speed = kDeviceSpeedUnit * std::max(setting(kTargetSpeed), 1);
  const auto go = [&](double target, double at) {
    begin(frame, MotionProfile::to(place, pace, target, at, acceleration()), now);
  };
  switch (frame.command) {
    case kHome:
      return go_home(frame, pace, now);
    case kMoveAbsolute:
      return go(zero_ + frame.data, speed);
    case kMoveRelative:
      return go(zero_ + counter(now) + frame.data, speed);
    case kMoveToStoredPosition:
      return go(zero_ + stored_[static_cast<std::size_t>(frame.data)], speed);
    case kConstantSpeed:
      if (frame.data == 0) return begin(frame, MotionProfile::to_rest(place, pace, acceleration()), now);
      return go(frame.data > 0 ? zero_ + setting(kMaximumPosition) : zero_, kDeviceSpeedUnit * std::abs(frame.data));
    default:
      return begin(frame, MotionProfile::to_rest(place, pace, acceleration()), now);
  }
}

void ChainDevice::receive(const ZaberFrame& frame, Nanoseconds now, std::uint8_t place,
                          std::vector<ZaberFrame>& replies) {
  const auto answer = [&](ZaberCommand command, std::int32_t data) { say(command, data, frame.id, replies); };
  const std::int32_t data = frame.data;
  const bool is_register = data >= 0 && data < static_cast<std::int32_t>(stored_.size());
  const bool homed = (setting(kMode) & kZaberHomed) != 0;
  switch (frame.command) {
    case kReset:
      return reset(now);
    case kHome:
    case kMoveToStoredPosition:
    case kMoveAbsolute:
    case kMoveRelative:
    case kConstantSpeed:
    case kStop:
      if (const std::int32_t error = error_of_move(frame, now); error != 0) return answer(kError, error);
      move(frame, now);
      return frame.command == kConstantSpeed ? answer(kConstantSpeed, data) : void();
    case kRenumber:
      if (frame.device != 0 && (data < 1 || data > 254)) return answer(kError, 2);
      number_ = frame.device == 0 ? place : static_cast<std::uint8_t>(data);
      return answer(kRenumber, options_.device_id);
    case kStorePosition:
      if (!is_register) return answer(kError, 1600);
      if (!homed) return answer(kError, 1601);
      stored_[static_cast<std::size_t>(data)] = counter(now);
      return answer(kStorePosition, data);
    case kReturnStoredPosition:
      if (!is_register) return answer(kError, 1700);
      return answer(kReturnStoredPosition, stored_[static_cast<std::size_t>(data)]);
    case kMemory:
      return answer(kMemory, memory(data));
    case kDeviceId:
      return answer(kDeviceId, options_.device_id);
    case kFirmware:
      return answer(kFirmware, options_.firmware);
    case kSupplyVoltage:
      return answer(kSupplyVoltage, options_.supply_decivolts);
    case kStatus:
      return answer(kStatus, under_way_ ? static_cast<std::int32_t>(under_way_->command) : kZaberIdle);
    case kEcho:
      return answer(kEcho, data);
    case kPosition:
      return answer(kPosition, counter(now));
    case kReturnSetting: {
      const auto asked = [&](const auto& each) { return static_cast<std::int32_t>(each.first) == data; };
      const auto found = std::find_if(settings_.begin(), settings_.end(), asked);
      const bool position = data == static_cast<std::int32_t>(kSetPosition);
      if (!position && found == settings_.end()) return answer(kError, 53);
      // Carries the setting's number, but replies to a "return" command, which mode bit 0 (silence) does not cover.
      return replies.push_back(
          {number_, static_cast<ZaberCommand>(data), position ? counter(now) : found->second, frame.id});
    }
    case kRestoreSettings:
      return data == 0 ? answer(kRestoreSettings, data) : answer(kError, 36);
    default:
      if (frame.command != kSetPosition && !settings_.contains(frame.command)) return answer(kError, 64);
      if (const std::int32_t error = error_of_setting(frame.command, data, now); error != 0) {
        return answer(kError, error);
      }
      change_setting(frame.command, data, now);
      return answer(frame.command, data);
  }
}

// The settings of a simulated T-Series device: which error refuses which value, and the effects of a change.

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
