// Codec of Zaber's binary protocol, T-Series, firmware 5: frames of six bytes <-> values, names of commands and
// errors, units. Facts: ZaberWiki, "RS-232 Communications Protocol/motion products" and "Manuals/Binary Protocol
// Manual" (2014). Not verified on hardware.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/clock.h"
#include "devices/units.h"

namespace tactbench::devices {

enum class ZaberCommand : std::uint8_t {
  kReset = 0,
  kHome = 1,
  kRenumber = 2,
  kMoveTracking = 8,
  kLimitActive = 9,
  kManualTracking = 10,
  kStorePosition = 16,
  kReturnStoredPosition = 17,
  kMoveToStoredPosition = 18,
  kMoveAbsolute = 20,
  kMoveRelative = 21,
  kConstantSpeed = 22,
  kStop = 23,
  kMemory = 35,
  kRestoreSettings = 36,
  kResolution = 37,
  kRunningCurrent = 38,
  kHoldCurrent = 39,
  kMode = 40,
  kHomeSpeed = 41,
  kTargetSpeed = 42,
  kAcceleration = 43,
  kMaximumPosition = 44,
  kSetPosition = 45,
  kMaximumRelativeMove = 46,
  kHomeOffset = 47,
  kAlias = 48,
  kLock = 49,
  kDeviceId = 50,
  kFirmware = 51,
  kSupplyVoltage = 52,
  kReturnSetting = 53,
  kStatus = 54,
  kEcho = 55,
  kPosition = 60,
  kError = 255,
};

// Mode bits, command 40.
inline constexpr std::int32_t kZaberNoAutoReply = 1 << 0;
inline constexpr std::int32_t kZaberKnobOff = 1 << 3;
inline constexpr std::int32_t kZaberMoveTracking = 1 << 4;
inline constexpr std::int32_t kZaberMessageIds = 1 << 6;
inline constexpr std::int32_t kZaberHomed = 1 << 7;  // cleared at power-up

// Replies to status (command 54) other than the number of the move command in progress.
inline constexpr std::int32_t kZaberIdle = 0;
inline constexpr std::int32_t kZaberHoming = 1;
inline constexpr std::int32_t kZaberByHand = 10;
inline constexpr std::int32_t kZaberStopping = 23;

inline constexpr std::size_t kZaberFrameBytes = 6;
inline constexpr std::int32_t kZaberDataMax = (1 << 23) - 1;  // signed, 24 bits
inline constexpr std::int32_t kZaberDataMin = -(1 << 23);
inline constexpr std::int32_t kZaberBusy = 255;  // the error code, not the command

using ZaberBytes = std::array<std::uint8_t, kZaberFrameBytes>;

// One instruction or reply with message ids: 24 bits of data and the id in the last byte. Without message ids the data
// has 32 bits; a value that fits in 24 bits reads the same, with `id` 0, or 255 for a negative value.
struct ZaberFrame {
  std::uint8_t device = 0;  // 0: all
  ZaberCommand command = ZaberCommand::kReset;
  std::int32_t data = 0;
  std::uint8_t id = 0;  // 0: unsolicited
  bool operator==(const ZaberFrame&) const = default;
};

// Throws Fault TB-STAGE-DATA when the data needs more than 24 bits, since the device would use another value.
[[nodiscard]] ZaberBytes encode(const ZaberFrame& frame);
[[nodiscard]] ZaberFrame decode(const ZaberBytes& bytes);
// Without message ids: data of 32 bits, `id` is ignored.
[[nodiscard]] ZaberBytes encode_without_id(const ZaberFrame& frame);
[[nodiscard]] ZaberFrame decode_without_id(const ZaberBytes& bytes);

[[nodiscard]] std::string name(ZaberCommand command);  // "move absolute (20)"
[[nodiscard]] std::string zaber_error_text(std::int32_t code);

// Cuts a stream of bytes into frames. There is no start byte and no checksum: an incomplete frame is dropped after
// `silence`, which is the only way to resynchronise.
class ZaberParser {
 public:
  explicit ZaberParser(Nanoseconds silence = std::chrono::milliseconds(10)) : silence_(silence) {}
  // Appends to `frames` those completed by `bytes`, which arrived at `time` (any clock, never decreasing).
  void add(std::span<const std::uint8_t> bytes, Nanoseconds time, std::vector<ZaberBytes>& frames);
  [[nodiscard]] std::size_t waiting() const { return filled_; }     // bytes of an incomplete frame
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }  // bytes, since construction

 private:
  Nanoseconds silence_;
  Nanoseconds last_{0};
  ZaberBytes partial_{};
  std::size_t filled_ = 0;
  std::uint64_t dropped_ = 0;
};

// A device and its units. Position: microsteps. Speed: data x 9.375 microsteps/s. Acceleration: data x 11250
// microsteps/s^2 (firmware 5; firmware 6 has other factors).
struct ZaberModel {
  std::int32_t device_id = 0;
  std::string_view name;
  double full_step_mm = 0.0;
  Millimetres travel;                  // written from memory, not from a source: configure it
  MillimetresPerSecond maximum_speed;  // also from memory: configure it
};

// nullptr when the id is not in the table: T-NA08A50 (5082), its relatives, T-LA60A (60), T-LA28A (28).
[[nodiscard]] const ZaberModel* zaber_model(std::int32_t device_id);

struct ZaberUnits {
  double microstep_mm = 0.0;  // full step / resolution; the resolution's default is 64
  [[nodiscard]] Millimetres position(std::int32_t microsteps) const;
  [[nodiscard]] MillimetresPerSecond speed(std::int32_t data) const;
  [[nodiscard]] double acceleration_mm_per_s2(std::int32_t data) const;  // 0 means the highest, 512 R - 1
  // The nearest value; none when it is not a number or needs more than 24 bits.
  [[nodiscard]] std::optional<std::int32_t> microsteps(Millimetres position) const;
  [[nodiscard]] std::optional<std::int32_t> speed_data(MillimetresPerSecond speed) const;
};

}  // namespace tactbench::devices
