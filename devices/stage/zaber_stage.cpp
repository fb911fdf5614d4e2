#include "devices/stage/zaber_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

using enum ZaberCommand;

constexpr double kMoveFactor = 1.25;  // of the expected time of a move

Nanoseconds from_seconds(double seconds) {
  return std::chrono::ceil<Nanoseconds>(std::chrono::duration<double>(seconds));
}

Activity activity_of(std::int32_t status) {
  return status == kZaberIdle       ? Activity::kIdle
         : status == kZaberHoming   ? Activity::kHoming
         : status == kZaberByHand   ? Activity::kByHand
         : status == kZaberStopping ? Activity::kStopping
                                    : Activity::kMoving;
}

std::string firmware_text(std::int32_t firmware) { return fmt::format("{}.{:02}", firmware / 100, firmware % 100); }

// The chain's state after these is not known: commands wait for arm().
bool breaks_link(const Fault& fault) {
  return fault.id().starts_with("TB-SERIAL-") || fault.id() == "TB-STAGE-TIMEOUT";
}

}  // namespace

// Locks the line for one short action, so that halt() waits only briefly; a waiting halt goes first.
template <class Action>
auto ZaberStage::exclusively(Action action) {
  check_armed();
  const std::lock_guard lock(mutex_);
  check_armed();
  try {
    return action();
  } catch (const Fault& fault) {
    if (breaks_link(fault)) drop();
    throw;
  }
}

void ZaberStage::check_halt() const {
  if (halting_ > 0 || halted_) {
    throw Fault("TB-STAGE-HALTED", "stage", "a command was given to the stage after it was halted; nothing was sent",
                "Find out why it was halted, then arm the stage again.");
  }
}

void ZaberStage::check_armed() const {
  check_halt();
  if (armed_) return;
  throw Fault("TB-STAGE-NOT-ARMED", "stage", "a command was given to the stage before it was armed; nothing was sent",
              "Arm the stage first, after a broken line too.");
}

void ZaberStage::refuse_target(Axis axis, const std::string& asked) const {
  throw Fault(
      "TB-STAGE-LIMIT", title(axis),
      fmt::format("{}: {} was requested, allowed is {:g} to {:g} mm at up to {:g} mm/s; nothing was sent", title(axis),
                  asked, option(axis).low.value(), option(axis).high.value(), option(axis).maximum_speed.value()),
      "Correct the recipe, or the stage's limits in the bench file.");
}

// Written so that NaN is refused too.
std::int32_t ZaberStage::target(Axis axis, Millimetres position) {
  const bool allowed = position >= option(axis).low && position <= option(axis).high;
  const auto steps = allowed ? record(axis).units.microsteps(position) : std::nullopt;
  if (!steps || *steps < 0 || *steps > record(axis).maximum_position) {
    refuse_target(axis, fmt::format("{:g} mm", position.value()));
  }
  return *steps;
}

std::int32_t ZaberStage::speed_data(Axis axis, MillimetresPerSecond speed) {
  const bool allowed = speed.value() > 0.0 && speed <= option(axis).maximum_speed;
  const auto data = allowed ? record(axis).units.speed_data(speed) : std::nullopt;
  if (!data || *data < 1) refuse_target(axis, fmt::format("{:g} mm/s", speed.value()));
  return *data;
}

// A device that lost power lost its home too, so its status is read before each move.
void ZaberStage::check_homed(Axis axis, bool ask_device) {
  if (ask_device) record(axis).homed = (setting(axis, kMode) & kZaberHomed) != 0;
  if (record(axis).homed) return;
  throw Fault("TB-STAGE-NOT-HOMED", title(axis),
              fmt::format("{} was asked to move and has not been homed; no move was sent", title(axis)),
              "Home the axis first; after a loss of power too.");
}

void ZaberStage::end_motion(Axis axis) {
  Record& one = record(axis);
  if (one.motion) line_->release(one.motion->id);
  one.motion.reset();
}

void ZaberStage::begin(Axis axis, ZaberCommand command, std::int32_t data, Nanoseconds expected, Nanoseconds longest) {
  end_motion(axis);  // the new instruction replaces the old one, which is no longer answered
  Motion motion;
  motion.command = command;
  motion.expected = clock_.now() + expected;
  motion.deadline = clock_.now() + longest;
  ++exchanges_;
  motion.id = line_->send(option(axis).device, command, data);
  record(axis).motion = motion;
}

void ZaberStage::start(Axis axis, ZaberCommand command, std::int32_t data, std::int32_t speed, std::int32_t target) {
  Record& one = record(axis);
  check_homed(axis, true);
  if (one.motion) one.microsteps = ask(axis, kPosition);
  // The target speed is not volatile: written only when it differs.
  if (command != kConstantSpeed && one.target_speed != speed) {
    one.target_speed = 0;
    one.target_speed = ask(axis, kTargetSpeed, speed);
  }
  // Trapezoid: distance / v + v / a; twice v / a more when it must reverse first.
  const double v = one.units.speed(speed).value();
  const double ramp =
      std::max(v, option(axis).maximum_speed.value()) / one.units.acceleration_mm_per_s2(one.acceleration);
  const double distance = std::abs((one.units.position(target) - one.units.position(one.microsteps)).value());
  const double takes = distance / v + v / one.units.acceleration_mm_per_s2(one.acceleration);
  begin(axis, command, data, from_seconds(takes),
        from_seconds(kMoveFactor * (takes + 2.0 * ramp)) + options_.move_margin);
  one.motion->target = target;
  (void)follow(axis);  // a refusal comes before the reply to the next query
}

void ZaberStage::start_move_to(Axis axis, Millimetres position, std::optional<MillimetresPerSecond> speed) {
  exclusively([&] {
    check_homed(axis, false);
    const std::int32_t steps = target(axis, position);
    start(axis, kMoveAbsolute, steps, speed_data(axis, speed.value_or(option(axis).maximum_speed)), steps);
  });
}

void ZaberStage::start_move_by(Axis axis, Millimetres distance, std::optional<MillimetresPerSecond> speed) {
  exclusively([&] {
    Record& one = record(axis);
    check_homed(axis, false);
    const std::int32_t pace = speed_data(axis, speed.value_or(option(axis).maximum_speed));
    (void)target(axis, one.units.position(one.microsteps) + distance);
    if (one.motion && !follow(axis)) {
      throw Fault("TB-STAGE-MOVING", title(axis),
                  fmt::format("{} was asked to move by {:g} mm while it moves; nothing was sent", title(axis),
                              distance.value()),
                  "Wait for the end of the move first.");
    }
    one.microsteps = ask(axis, kPosition);  // it may have been turned by hand
    const std::int32_t end = target(axis, one.units.position(one.microsteps) + distance);
    start(axis, kMoveRelative, end - one.microsteps, pace, end);
  });
}

void ZaberStage::start_speed(Axis axis, MillimetresPerSecond speed) {
  exclusively([&] {
    Record& one = record(axis);
    check_homed(axis, false);
    const std::int32_t pace = speed_data(axis, MillimetresPerSecond(std::abs(speed.value())));
    const bool up = speed.value() > 0.0;
    const auto limit = one.units.microsteps(up ? option(axis).high : option(axis).low);
    const std::int32_t device_limit = up ? one.maximum_position : 0;
    const std::int32_t end = std::clamp(limit.value_or(device_limit), 0, one.maximum_position);
    // The device stops by itself only at its own limit; for a narrower one a move to it has the same effect.
    if (end == device_limit) return start(axis, kConstantSpeed, up ? pace : -pace, pace, end);
    start(axis, kMoveAbsolute, end, pace, end);
  });
}

// One query about a motion under way. True: it has ended, and the record holds the position.
bool ZaberStage::follow(Axis axis) {
  Record& one = record(axis);
  if (!one.motion) return true;
  const std::int32_t status = ask(axis, kStatus);
  const Motion motion = *one.motion;
  if (!motion.reply && status != kZaberIdle) {
    if (clock_.now() < motion.deadline) return false;
    end_motion(axis);
    line_->send_without_id(option(axis).device, kStop, 0);
    (void)ask(axis, kStatus);  // a reply means that the stop was read
    throw Fault("TB-STAGE-OVERDUE", title(axis),
                fmt::format("{}: {} should have ended by now and has not (status {}); a stop was sent", title(axis),
                            name(motion.command), status),
                "Check that nothing blocks the axis; home it again before the next move.");
  }
  if (motion.reply && motion.reply->command == kError) {
    const bool again = motion.command == kStop && motion.reply->data == kZaberBusy && clock_.now() < motion.deadline;
    end_motion(axis);
    if (!again) refuse(axis, motion.command, motion.reply->data);
    // A homing device may refuse to stop: the command is repeated until it is at rest. Not verified on hardware.
    begin(axis, kStop, 0, Nanoseconds(0), motion.deadline - clock_.now());
    return false;
  }
  // Idle without a reply: the reply was lost on the way, so the position is read from the device.
  one.microsteps = motion.reply ? motion.reply->data : ask(axis, kPosition);
  end_motion(axis);
  if (motion.target && one.microsteps != *motion.target) {
    throw Fault("TB-STAGE-ASTRAY", title(axis),
                fmt::format("{} was sent to {:g} mm and stands at {:g} mm", title(axis),
                            one.units.position(*motion.target).value(), one.units.position(one.microsteps).value()),
                "Check that nothing blocks the axis and no other program moves it; home it again.");
  }
  return true;
}

Millimetres ZaberStage::wait(Axis axis) {
  for (;;) {
    Nanoseconds next{};
    const bool ended = exclusively([&] {
      if (follow(axis)) return true;
      // Polled often while far from the expected end, and again right at it.
      const Nanoseconds now = clock_.now();
      next = now + std::clamp(record(axis).motion->expected - now, options_.poll_interval / 8, options_.poll_interval);
      return false;
    });
    if (ended) return record(axis).units.position(record(axis).microsteps);
    clock_.wait_until(next);
  }
}

void ZaberStage::home(Axis axis) {
  exclusively([&] {
    record(axis).homed = false;
    begin(axis, kHome, 0, option(axis).home_timeout, option(axis).home_timeout);
  });
  (void)wait(axis);
  exclusively([&] { check_homed(axis, true); });
}

bool ZaberStage::send_home(Axis axis) noexcept {
  const std::lock_guard lock(mutex_);
  armed_ = false;
  try {
    open();
    // The reply comes at the end of the travel. The wait lets the command arrive before a manual clock advances.
    (void)line_->ask_without_id(option(axis).device, kHome, 0);
    clock_.reply_lost(options_.reply_timeout);
  } catch (...) {
    drop();  // the line may come back
    return false;
  }
  return true;
}

Millimetres ZaberStage::stop(Axis axis) {
  exclusively([&] {
    const Record& one = record(axis);
    const double ramp = option(axis).maximum_speed.value() / one.units.acceleration_mm_per_s2(one.acceleration);
    begin(axis, kStop, 0, from_seconds(ramp), from_seconds(kMoveFactor * ramp) + options_.move_margin);
  });
  return wait(axis);
}

AxisState ZaberStage::state(Axis axis) {
  return exclusively([&] {
    Record& one = record(axis);
    AxisState result;
    const std::int32_t status = ask(axis, kStatus);
    one.microsteps = ask(axis, kPosition);
    result.time = clock_.now();
    result.position = one.units.position(one.microsteps);
    result.microsteps = one.microsteps;
    result.homed = one.homed;
    result.activity = activity_of(status);
    return result;
  });
}

// ZaberStage's exchanges with the chain: queries, arming, identification, halt.

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
    const auto reply = plainly ? line_->ask_without_id(device, command, data) : line_->ask(device, command, data);
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

std::int32_t ZaberStage::ask_without_id(Axis axis, ZaberCommand command, std::int32_t data) {
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
  clock_thread_ = std::this_thread::get_id();
  drop();  // each axis's record starts again below: motions under way are discarded, and nothing is sent again
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
  const AxisIdentity found = identify(axis);
  if (!found.complaint.empty()) {
    one = Record{};
    throw Fault(found.present ? "TB-STAGE-WRONG-DEVICE" : "TB-STAGE-TIMEOUT", title(axis), found.complaint,
                "Check power and cable, the order of the chain, and the device numbers in the bench file.");
  }
  one.microsteps = found.microsteps;
  // The mode is not volatile: written only when it differs. Home status is one of its bits and must stay.
  const std::int32_t mode = ask_without_id(axis, kReturnSetting, static_cast<std::int32_t>(kMode));
  const std::int32_t wanted = (mode | kZaberMessageIds | (options_.knob_off ? kZaberKnobOff : 0)) & ~kZaberNoAutoReply;
  if (mode != wanted) (void)ask_without_id(axis, kMode, wanted);
  const std::int32_t stands = setting(axis, kMode);
  if (stands != wanted) {
    throw Fault("TB-STAGE-REFUSED", title(axis),
                fmt::format("{} was given device mode {} and returns {}", title(axis), wanted, stands),
                "Check the device's firmware version: 5.xx is expected.");
  }
  one.homed = (stands & kZaberHomed) != 0;
  const ZaberModel* model = zaber_model(one.device_id);
  if (model == nullptr) {
    throw Fault("TB-STAGE-WRONG-DEVICE", title(axis),
                fmt::format("{}: the units of device id {} are not known", title(axis), one.device_id),
                "Use a T-NA08A or T-LA device.");
  }
  const std::int32_t resolution = setting(axis, kResolution);
  one.units.microstep_mm = model->full_step_mm / (resolution > 0 ? resolution : kFullResolution);
  one.maximum_position = setting(axis, kMaximumPosition);
  if (one.maximum_position < 0) one.maximum_position = kZaberDataMax;  // negative: it needs more than 24 bits
  one.acceleration = setting(axis, kAcceleration);
  one.target_speed = setting(axis, kTargetSpeed);
  if (found.activity != Activity::kIdle) {
    // A move of another program: wait for its end, do not take it over.
    one.motion = Motion{};
    one.motion->deadline = one.motion->expected = clock_.now() + option(axis).home_timeout;
  }
}

AxisIdentity ZaberStage::identify(Axis axis) {
  const ZaberAxisOptions& expected = option(axis);
  std::int32_t device_id = 0, firmware = 0;
  AxisIdentity found;
  found.axis = axis;
  try {
    device_id = ask_without_id(axis, kDeviceId);
    firmware = ask_without_id(axis, kFirmware);
    found.supply = Volts(ask_without_id(axis, kSupplyVoltage) / 10.0);
    found.activity = activity_of(ask_without_id(axis, kStatus));
    found.microsteps = ask_without_id(axis, kPosition);
  } catch (const Fault& fault) {
    if (fault.id() != "TB-STAGE-TIMEOUT") throw;
    found.complaint = fault.what();
    found.remedy = "check the daisy chain's cables and power, and [stage.x], [stage.y], [stage.z] device";
    return found;
  }
  found.present = true;
  found.id = std::to_string(device_id);
  found.firmware = firmware_text(firmware);
  record(axis).device_id = device_id;
  record(axis).firmware = firmware;
  if (const ZaberModel* model = zaber_model(device_id); model != nullptr) {
    found.position = ZaberUnits{model->full_step_mm / kFullResolution}.position(found.microsteps);
  }
  if (device_id != expected.device_id) {
    found.complaint =
        fmt::format("{}: device id {} answers, {} is expected", title(axis), device_id, expected.device_id);
  } else if (firmware < expected.firmware_low || firmware > expected.firmware_high) {
    found.complaint = fmt::format("{}: firmware {} answers, {} to {} is expected", title(axis), found.firmware,
                                  firmware_text(expected.firmware_low), firmware_text(expected.firmware_high));
  }
  if (!found.complaint.empty()) found.remedy = "correct device_id in the bench file, or the chain";
  return found;
}

std::vector<AxisIdentity> ZaberStage::identify() {
  const std::lock_guard lock(mutex_);
  std::vector<AxisIdentity> found;
  try {
    open();
    for (const Axis axis : kAll) {
      clock_.wait_until(clock_.now());  // feeds the supervision of this program: an absent axis takes long
      found.push_back(identify(axis));
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
  if (std::this_thread::get_id() == clock_thread_) {
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
  line_->send_without_id(0, kStop, 0);
  std::array<bool, kAxes> stands{};
  std::array<int, kAxes> unanswered{};
  for (Nanoseconds waited{0}; waited <= options_.halt_timeout; waited += kHaltPoll) {
    bool more = false;
    for (const Axis axis : kAll) {
      const std::size_t i = index(axis);
      if (stands[i] || unanswered[i] >= kAttempts) continue;
      ++exchanges_;
      const auto reply = line_->ask_without_id(option(axis).device, kStatus, 0);
      if (!reply) ++unanswered[i];
      stands[i] = reply && reply->command == kStatus && reply->data == kZaberIdle;
      // A homing device may refuse to stop (255, busy): repeated until it is at rest. Not verified on hardware.
      if (reply && !stands[i] && reply->data != kZaberStopping) line_->send_without_id(option(axis).device, kStop, 0);
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
                      option(axis).serial, one.firmware != 0 ? firmware_text(one.firmware) : "", options_.origin});
  }
  return result;
}

}  // namespace tactbench::devices
