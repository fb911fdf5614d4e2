#include "devices/stage/zaber_retreat.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <utility>

namespace tactbench::devices {
namespace {

using enum ZaberCommand;
using RetreatClock = std::chrono::steady_clock;

constexpr Nanoseconds kPoll = std::chrono::milliseconds(20);
constexpr std::int32_t kRetreatResolution = 64;

class Retreat {
 public:
  Retreat(std::unique_ptr<ByteStream> stream, const ZaberStageOptions& options)
      : options_(options), line_(std::move(stream), options.reply_timeout, options.frame_silence, [](auto&) {}) {}

  StageRetreat carry_out(Millimetres back_off, Nanoseconds move_timeout) {
    StageRetreat result;
    result.stands = stop_all();
    result.text = result.stands ? "stage stands" : "the stage did NOT answer that it stands";
    move_away(back_off, move_timeout, result);
    return result;
  }

 private:
  [[nodiscard]] std::uint8_t z() const { return options_.axes.back().device; }

  std::optional<std::int32_t> ask(std::uint8_t device, ZaberCommand command, std::int32_t data = 0) {
    for (int attempt = 0; attempt < 2; ++attempt) {
      const auto reply = line_.ask_without_id(device, command, data);
      if (reply && reply->command != kError) return reply->data;
    }
    return std::nullopt;
  }

  bool stop_all() {
    line_.settle();
    line_.send_without_id(0, kStop, 0);
    std::array<bool, kAxes> stands{};
    const auto end = RetreatClock::now() + options_.halt_timeout;
    while (RetreatClock::now() < end) {
      for (std::size_t i = 0; i < stands.size(); ++i) {
        if (stands[i]) continue;
        const std::uint8_t device = options_.axes[i].device;
        const auto status = line_.ask_without_id(device, kStatus, 0);
        stands[i] = status && status->command == kStatus && status->data == kZaberIdle;
        // A homing device may refuse to stop: the command is repeated until it is at rest.
        if (status && !stands[i] && status->data != kZaberStopping) line_.send_without_id(device, kStop, 0);
      }
      if (std::find(stands.begin(), stands.end(), false) == stands.end()) return true;
      std::this_thread::sleep_for(kPoll);
    }
    return false;
  }

  void move_away(Millimetres back_off, Nanoseconds move_timeout, StageRetreat& result) {
    const auto mode = ask(z(), kReturnSetting, static_cast<std::int32_t>(kMode));
    const auto position = ask(z(), kPosition);
    const ZaberModel* model = zaber_model(options_.axes.back().device_id);
    if (!mode || !position || model == nullptr) {
      result.text += "; z did not answer and was not backed off";
      return;
    }
    if ((*mode & kZaberHomed) == 0) {
      result.text += "; z was not homed and was not backed off";
      return;
    }
    const auto resolution = ask(z(), kReturnSetting, static_cast<std::int32_t>(kResolution));
    ZaberUnits units;
    units.microstep_mm = model->full_step_mm / (resolution && *resolution > 0 ? *resolution : kRetreatResolution);
    const std::int32_t target = std::max(0, *position - units.microsteps(back_off).value_or(*position));
    // The target speed may still be that of a slow approach. A non-negative target reads the same with and without ids.
    if (const auto speed = units.speed_data(options_.axes.back().maximum_speed)) (void)ask(z(), kTargetSpeed, *speed);
    line_.send_without_id(z(), kMoveAbsolute, target);
    const auto end = RetreatClock::now() + move_timeout;
    std::optional<std::int32_t> now = position;
    while (now != target && RetreatClock::now() < end) {
      std::this_thread::sleep_for(kPoll);
      now = ask(z(), kPosition);
    }
    result.backed_off = now == target;
    result.text += fmt::format("; z from {:.2f} to {}", units.position(*position).value(),
                               now ? fmt::format("{:.2f} mm", units.position(*now).value()) : "an unknown position");
  }

  const ZaberStageOptions& options_;
  ZaberLine line_;
};

}  // namespace

StageRetreat retreat(std::unique_ptr<ByteStream> stream, const ZaberStageOptions& options, Millimetres back_off,
                     Nanoseconds move_timeout) {
  return Retreat(std::move(stream), options).carry_out(back_off, move_timeout);
}

}  // namespace tactbench::devices
