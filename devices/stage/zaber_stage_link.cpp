// ZaberStage's exchanges with the chain: queries, arming, identification, halt.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "devices/fault.h"
#include "devices/stage/zaber_stage.h"

namespace tactbench::devices {
namespace {

using enum ZaberCommand;

constexpr Nanoseconds kRenumberingSilence = std::chrono::seconds(1);  // the host must send nothing meanwhile
constexpr Nanoseconds kHaltPoll = std::chrono::milliseconds(20);
constexpr int kAttempts = 2;
constexpr std::int32_t kFullResolution = 64;
constexpr Axis kAll[] = {Axis::kX, Axis::kY, Axis::kZ};
constexpr std::string_view kNames[] = {"stage x", "stage y", "stage z"};

}  // namespace

ZaberStage::ZaberStage(Factory open, ZaberStageOptions options, Clock& clock)
    : open_(std::move(open)), options_(std::move(options)), clock_(clock) {}

std::string ZaberStage::title(Axis axis) const {
  return fmt::format("{} (device {})", kNames[index(axis)], option(axis).device);
}

void ZaberStage::refuse(Axis axis, ZaberCommand command, std::int32_t error) const {
  throw Fault("TB-STAGE-REFUSED", title(axis),
              fmt::format("{} refused {}: {}", title(axis), name(command), zaber_error_text(error)),
              "Correct the stage's limits, speeds and settings in the bench file, or its supply.");
}

void ZaberStage::open() {
  if (line_) return;
  line_ = std::make_unique<ZaberLine>(open_(), options_.reply_timeout, options_.frame_silence,
                                      [this](const ZaberFrame& frame) { listen(frame); });
  line_->settle();
}

void ZaberStage::drop() noexcept {
  armed_ = false;
  line_.reset();
}

void ZaberStage::listen(const ZaberFrame& frame) {
  for (const Axis axis : kAll) {
    if (option(axis).device != frame.device) continue;
    Record& one = record(axis);
    const bool tracks = frame.command == kMoveTracking || frame.command == kManualTracking;
    const bool limit = frame.command == kLimitActive && one.motion && one.motion->command == kConstantSpeed;
    if (frame.id != 0 && one.motion && frame.id == one.motion->id) {
      // A move at constant speed is answered at once; its end is reported as "limit active".
      if (frame.command != kConstantSpeed) one.motion->reply = frame;
    } else if (frame.id == 0 && limit) {
      one.motion->reply = frame;
    } else if (frame.id == 0 && tracks) {
      one.microsteps = frame.data;
    } else if (frame.id == 0 && frame.command == kError) {
      one.complaint = frame.data;
    }
  }
}

std::int32_t ZaberStage::asked(Axis axis, ZaberCommand command, std::int32_t data, bool plainly) {
  const std::uint8_t device = option(axis).device;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    check_halt();
    ++exchanges_;
    const auto reply = plainly ? line_->ask_plainly(device, command, data) : line_->ask(device, command, data);
    for (const Axis other : kAll) {
      if (const auto complaint = std::exchange(record(other).complaint, std::nullopt)) {
        throw Fault("TB-STAGE-REFUSED", title(other),
                    fmt::format("{} reports unasked: {}", title(other), zaber_error_text(*complaint)),
                    "Check the stage's supply and that nothing blocks it.");
      }
    }
    if (reply && reply->command == kError) refuse(axis, command, reply->data);
    if (reply) return reply->data;
    clock_.reply_lost(options_.reply_timeout);
  }
  throw Fault("TB-STAGE-TIMEOUT", title(axis),
              fmt::format("{} was queried for {} {} times and did not answer within {:g} s each", title(axis),
                          name(command), kAttempts, std::chrono::duration<double>(options_.reply_timeout).count()),
              "Check the stage's power, the cable and the device numbers in the bench file.");
}

std::int32_t ZaberStage::ask(Axis axis, ZaberCommand command, std::int32_t data) {
  return asked(axis, command, data, false);
}

std::int32_t ZaberStage::ask_plainly(Axis axis, ZaberCommand command, std::int32_t data) {
  return asked(axis, command, data, true);
}

std::int32_t ZaberStage::setting(Axis axis, ZaberCommand command) {
  return ask(axis, kReturnSetting, static_cast<std::int32_t>(command));
}

void ZaberStage::renumber() {
  line_->renumber(kAxes, kRenumberingSilence + options_.reply_timeout);
  clock_.wait_until(clock_.now() + kRenumberingSilence);
  line_->settle();
}

void ZaberStage::arm() {
  const std::lock_guard lock(mutex_);
  turner_ = std::this_thread::get_id();
  drop();  // each axis's record begins anew below: motions under way are discarded, and nothing is sent again
  halted_ = false;
  try {
    open();
    if (options_.renumber) renumber();
    for (const Axis axis : kAll) arm(axis);
  } catch (...) {
    drop();
    throw;
  }
  armed_ = true;
}

void ZaberStage::arm(Axis axis) {
  Record& one = record(axis);
  one = Record{};
  const ZaberIdentity found = identify(axis);
  if (!found.complaint.empty()) {
    throw Fault(found.present ? "TB-STAGE-WRONG-DEVICE" : "TB-STAGE-TIMEOUT", title(axis), found.complaint,
                "Check power and cable, the order of the chain, and the device numbers in the bench file.");
  }
  one.device_id = found.device_id;
  one.firmware = found.firmware;
  one.microsteps = found.microsteps;
  // The mode is not volatile: written only when it differs. Home status is one of its bits and must stay.
  const std::int32_t mode = ask_plainly(axis, kReturnSetting, static_cast<std::int32_t>(kMode));
  const std::int32_t wanted = (mode | kZaberMessageIds | (options_.knob_off ? kZaberKnobOff : 0)) & ~kZaberNoAutoReply;
  if (mode != wanted) (void)ask_plainly(axis, kMode, wanted);
  const std::int32_t stands = setting(axis, kMode);
  if (stands != wanted) {
    throw Fault("TB-STAGE-REFUSED", title(axis),
                fmt::format("{} was given device mode {} and returns {}", title(axis), wanted, stands),
                "Check the device's firmware version: 5.xx is expected.");
  }
  one.homed = (stands & kZaberHomed) != 0;
  const ZaberModel* model = zaber_model(found.device_id);
  if (model == nullptr) {
    throw Fault("TB-STAGE-WRONG-DEVICE", title(axis),
                fmt::format("{}: the units of device id {} are not known", title(axis), found.device_id),
                "Use a T-NA08A or T-LA device.");
  }
  const std::int32_t resolution = setting(axis, kResolution);
  one.units.microstep_mm = model->full_step_mm / (resolution > 0 ? resolution : kFullResolution);
  one.maximum_position = setting(axis, kMaximumPosition);
  if (one.maximum_position < 0) one.maximum_position = kZaberDataMax;  // negative: it needs more than 24 bits
  one.acceleration = setting(axis, kAcceleration);
  one.target_speed = setting(axis, kTargetSpeed);
  if (found.status != kZaberIdle) {
    // A move of another program: wait for its end, do not take it over.
    one.motion = Motion{};
    one.motion->deadline = one.motion->expected = clock_.now() + option(axis).home_timeout;
  }
}

ZaberIdentity ZaberStage::identify(Axis axis) {
  const ZaberAxisOptions& expected = option(axis);
  ZaberIdentity found;
  found.axis = axis;
  try {
    found.device_id = ask_plainly(axis, kDeviceId);
    found.firmware = ask_plainly(axis, kFirmware);
    found.supply = Volts(ask_plainly(axis, kSupplyVoltage) / 10.0);
    found.status = ask_plainly(axis, kStatus);
    found.microsteps = ask_plainly(axis, kPosition);
  } catch (const Fault& fault) {
    if (fault.id() != "TB-STAGE-TIMEOUT") throw;
    found.complaint = fault.what();
    return found;
  }
  found.present = true;
  if (found.device_id != expected.device_id) {
    found.complaint =
        fmt::format("{}: device id {} answers, {} is expected", title(axis), found.device_id, expected.device_id);
  } else if (found.firmware < expected.firmware_low || found.firmware > expected.firmware_high) {
    found.complaint =
        fmt::format("{}: firmware {}.{:02} answers, {}.{:02} to {}.{:02} is expected", title(axis),
                    found.firmware / 100, found.firmware % 100, expected.firmware_low / 100,
                    expected.firmware_low % 100, expected.firmware_high / 100, expected.firmware_high % 100);
  }
  return found;
}

std::vector<ZaberIdentity> ZaberStage::identify() {
  const std::lock_guard lock(mutex_);
  std::vector<ZaberIdentity> found;
  try {
    open();
    for (const Axis axis : kAll) {
      clock_.wait_until(clock_.now());  // feeds the supervision of this program: an absent axis takes long
      found.push_back(identify(axis));
      if (!found.back().present) continue;
      record(axis).device_id = found.back().device_id;
      record(axis).firmware = found.back().firmware;
    }
  } catch (...) {
    drop();
    throw;
  }
  if (!armed_) drop();
  return found;
}

void ZaberStage::disarm() noexcept {
  const std::lock_guard lock(mutex_);
  drop();
}

void ZaberStage::pause(Nanoseconds span) {
  if (std::this_thread::get_id() == turner_) {
    clock_.wait_until(clock_.now() + span);
  } else {
    std::this_thread::sleep_for(span);
  }
}

bool ZaberStage::halt() noexcept {
  ++halting_;
  const std::lock_guard lock(mutex_);
  armed_ = false;
  halted_ = true;
  bool stands = false;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    try {
      open();
      stands = stop_all();
      break;
    } catch (...) {
      drop();  // the line may come back
    }
  }
  --halting_;
  return stands;
}

// Without message ids, since the devices' mode may be unknown. True: each reported that it is at rest.
bool ZaberStage::stop_all() {
  line_->settle();
  line_->send_plainly(0, kStop, 0);
  std::array<bool, kAxes> stands{};
  std::array<int, kAxes> unanswered{};
  for (Nanoseconds waited{0}; waited <= options_.halt_timeout; waited += kHaltPoll) {
    bool more = false;
    for (const Axis axis : kAll) {
      const std::size_t i = index(axis);
      if (stands[i] || unanswered[i] >= kAttempts) continue;
      ++exchanges_;
      const auto reply = line_->ask_plainly(option(axis).device, kStatus, 0);
      if (!reply) ++unanswered[i];
      stands[i] = reply && reply->command == kStatus && reply->data == kZaberIdle;
      // A homing device may refuse to stop (255, busy): repeated until it is at rest. Not verified on hardware.
      if (reply && !stands[i] && reply->data != kZaberStopping) line_->send_plainly(option(axis).device, kStop, 0);
      more = more || !stands[i];
    }
    if (!more) break;
    pause(kHaltPoll);
  }
  return std::find(stands.begin(), stands.end(), false) == stands.end();
}

std::vector<Identity> ZaberStage::identities() const {
  std::vector<Identity> result;
  for (const Axis axis : kAll) {
    const Record& one = records_.at(index(axis));
    const ZaberModel* model = zaber_model(one.device_id != 0 ? one.device_id : option(axis).device_id);
    result.push_back({std::string(kNames[index(axis)]), model != nullptr ? "Zaber " + std::string(model->name) : "",
                      option(axis).serial,
                      one.firmware != 0 ? fmt::format("{}.{:02}", one.firmware / 100, one.firmware % 100) : "",
                      options_.origin});
  }
  return result;
}

}  // namespace tactbench::devices
