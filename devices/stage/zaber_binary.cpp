#include "devices/stage/zaber_binary.h"

#include <fmt/format.h>

#include <cmath>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

constexpr double kSpeedUnit = 9.375;           // microsteps/s
constexpr double kAccelerationUnit = 11250.0;  // microsteps/s^2
constexpr std::int32_t kHighestAcceleration = 32767;

struct Named {
  std::int32_t number;
  std::string_view text;
};

constexpr Named kCommands[] = {
    {0, "reset"},
    {1, "home"},
    {2, "renumber"},
    {8, "move tracking"},
    {9, "limit active"},
    {10, "manual move tracking"},
    {16, "store position"},
    {17, "return stored position"},
    {18, "move to stored position"},
    {20, "move absolute"},
    {21, "move relative"},
    {22, "constant speed"},
    {23, "stop"},
    {35, "read or write memory"},
    {36, "restore settings"},
    {37, "microstep resolution"},
    {38, "running current"},
    {39, "hold current"},
    {40, "device mode"},
    {41, "home speed"},
    {42, "target speed"},
    {43, "acceleration"},
    {44, "maximum position"},
    {45, "set position"},
    {46, "maximum relative move"},
    {47, "home offset"},
    {48, "alias"},
    {49, "lock state"},
    {50, "device id"},
    {51, "firmware version"},
    {52, "supply voltage"},
    {53, "return setting"},
    {54, "status"},
    {55, "echo"},
    {60, "position"},
    {255, "error"},
};

constexpr Named kErrors[] = {
    {1, "cannot home: the home sensor was not found"},
    {2, "the device number is out of range"},
    {14, "the supply voltage is too low"},
    {15, "the supply voltage is too high"},
    {18, "the stored position is no longer valid"},
    {20, "the absolute target is out of range"},
    {21, "the relative target is out of range"},
    {22, "the speed is out of range"},
    {36, "the peripheral id is not known"},
    {37, "the microstep resolution is not allowed"},
    {38, "the running current is out of range"},
    {39, "the hold current is out of range"},
    {40, "the device mode is not allowed"},
    {41, "the home speed is out of range"},
    {42, "the target speed is out of range"},
    {43, "the acceleration is out of range"},
    {44, "the maximum position is out of range"},
    {45, "the current position is out of range"},
    {46, "the maximum relative move is out of range"},
    {47, "the home offset is out of range"},
    {48, "the alias is out of range"},
    {49, "the lock state is neither 0 nor 1"},
    {50, "the device id is not known"},
    {53, "there is no such setting to return"},
    {64, "the command is not known"},
    {255, "busy: another command is under way that this one may not interrupt"},
    {1600, "there is no such register to store a position in"},
    {1601, "a position cannot be stored before homing"},
    {1700, "there is no such register to return a position from"},
    {1800, "there is no such register to move to"},
    {1801, "no move to a stored position before homing"},
    {2146, "the relative move is longer than the maximum relative move"},
    {3600, "the settings are locked"},
    {4001, "mode bit 1 (anti-backlash) is not allowed"},
    {4002, "mode bit 2 (anti-sticktion) is not allowed"},
    {4008, "mode bit 8 (no auto-home) is not allowed on a linear device"},
    {4010, "mode bit 10 is reserved"},
    {4011, "mode bit 11 (circular microstepping) is not allowed"},
    {4012, "mode bit 12 (home switch polarity) is not allowed"},
    {4013, "mode bit 13 is reserved"},
    {4014, "mode bit 14 (power light off) is not allowed"},
    {4015, "mode bit 15 (serial light off) is not allowed"},
};

constexpr double kNaFullStep = 0.003048;
constexpr double kLaFullStep = 0.00635;
constexpr ZaberModel kModels[] = {
    {5081, "T-NA08A25", kNaFullStep, Millimetres(25.4), MillimetresPerSecond(8.0)},
    {5082, "T-NA08A50", kNaFullStep, Millimetres(50.8), MillimetresPerSecond(8.0)},
    {5085, "T-NA08A25-S", kNaFullStep, Millimetres(25.4), MillimetresPerSecond(8.0)},
    {5086, "T-NA08A50-S", kNaFullStep, Millimetres(50.8), MillimetresPerSecond(8.0)},
    {5091, "T-NA08A25-SV2", kNaFullStep, Millimetres(25.4), MillimetresPerSecond(8.0)},
    {5092, "T-NA08A50-SV2", kNaFullStep, Millimetres(50.8), MillimetresPerSecond(8.0)},
    {5095, "T-NA08A25-SV1", kNaFullStep, Millimetres(25.4), MillimetresPerSecond(8.0)},
    {5096, "T-NA08A50-SV1", kNaFullStep, Millimetres(50.8), MillimetresPerSecond(8.0)},
    {28, "T-LA28A", kLaFullStep, Millimetres(28.0), MillimetresPerSecond(4.0)},
    {60, "T-LA60A", kLaFullStep, Millimetres(60.0), MillimetresPerSecond(4.0)},
};

std::optional<std::int32_t> rounded(double value) {
  const double nearest = std::round(value);
  if (!(nearest >= kZaberDataMin && nearest <= kZaberDataMax)) return std::nullopt;  // NaN too
  return static_cast<std::int32_t>(nearest);
}

}  // namespace

ZaberBytes encode_without_id(const ZaberFrame& frame) {
  ZaberBytes bytes{frame.device, static_cast<std::uint8_t>(frame.command)};
  auto data = static_cast<std::uint32_t>(frame.data);
  for (std::size_t i = 2; i < kZaberFrameBytes; ++i, data >>= 8U) bytes[i] = static_cast<std::uint8_t>(data & 0xFFU);
  return bytes;
}

ZaberBytes encode(const ZaberFrame& frame) {
  if (frame.data < kZaberDataMin || frame.data > kZaberDataMax) {
    throw Fault("TB-STAGE-DATA", fmt::format("stage device {}", frame.device),
                fmt::format("{} with data {} was requested, which needs more than 24 bits; nothing was sent",
                            name(frame.command), frame.data),
                "Correct the stage's travel and limits in the bench file.");
  }
  ZaberBytes bytes = encode_without_id(frame);
  bytes[5] = frame.id;
  return bytes;
}

ZaberFrame decode_without_id(const ZaberBytes& bytes) {
  std::uint32_t data = 0;
  for (std::size_t i = kZaberFrameBytes; i > 2; --i) data = data << 8U | bytes[i - 1];
  return {bytes[0], static_cast<ZaberCommand>(bytes[1]), static_cast<std::int32_t>(data), 0};
}

ZaberFrame decode(const ZaberBytes& bytes) {
  ZaberBytes extended = bytes;
  extended[5] = (bytes[4] & 0x80U) != 0 ? 0xFF : 0x00;
  ZaberFrame frame = decode_without_id(extended);
  frame.id = bytes[5];
  return frame;
}

std::string name(ZaberCommand command) {
  const auto number = static_cast<std::int32_t>(command);
  for (const Named& known : kCommands) {
    if (known.number == number) return fmt::format("{} ({})", known.text, number);
  }
  return fmt::format("command {}", number);
}

std::string zaber_error_text(std::int32_t code) {
  for (const Named& known : kErrors) {
    if (known.number == code) return fmt::format("error {}: {}", code, known.text);
  }
  return fmt::format("error {}, which is not in the manual of firmware 5", code);
}

void ZaberParser::add(std::span<const std::uint8_t> bytes, Nanoseconds time, std::vector<ZaberBytes>& frames) {
  if (bytes.empty()) return;
  if (filled_ > 0 && time - last_ > silence_) {
    dropped_ += filled_;
    filled_ = 0;
  }
  last_ = time;
  for (const std::uint8_t byte : bytes) {
    partial_[filled_++] = byte;
    if (filled_ < kZaberFrameBytes) continue;
    frames.push_back(partial_);
    filled_ = 0;
  }
}

const ZaberModel* zaber_model(std::int32_t device_id) {
  for (const ZaberModel& model : kModels) {
    if (model.device_id == device_id) return &model;
  }
  return nullptr;
}

Millimetres ZaberUnits::position(std::int32_t microsteps) const { return Millimetres(microsteps * microstep_mm); }

MillimetresPerSecond ZaberUnits::speed(std::int32_t data) const {
  return MillimetresPerSecond(data * kSpeedUnit * microstep_mm);
}

double ZaberUnits::acceleration_mm_per_s2(std::int32_t data) const {
  return (data == 0 ? kHighestAcceleration : data) * kAccelerationUnit * microstep_mm;
}

std::optional<std::int32_t> ZaberUnits::microsteps(Millimetres position) const {
  return rounded(position.value() / microstep_mm);
}

std::optional<std::int32_t> ZaberUnits::speed_data(MillimetresPerSecond speed) const {
  return rounded(speed.value() / (kSpeedUnit * microstep_mm));
}

}  // namespace tactbench::devices
