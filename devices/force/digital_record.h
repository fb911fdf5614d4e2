// Codec of the ATI Digital F/T (RS-485): Modbus RTU frames to start it and to read its calibration, and the samples of
// its stream. Bytes to values and back, no I/O. Known from one public driver only: not verified on hardware.
//
// Sample, 13 bytes: six i16 big-endian, gauges in the order G0 G2 G4 G1 G3 G5, then a byte whose bit 7 is a status
//   error and whose bits 0-6 are the sum of the twelve bytes, modulo 128.
// Calibration, 338 bytes (169 registers from 0x00E3): serial[8], part[32], family[4], date[20], f32 matrix[6][6], u8
//   force unit, u8 torque unit, f32 range[6], i32 counts per force, i32 counts per torque, u16 gain[6], u16 offset[6],
//   72 unused bytes. All big-endian (the order of a value's two registers is not verified).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"

namespace tactbench::devices {

inline constexpr std::size_t kDigitalSampleBytes = 13;
inline constexpr std::size_t kDigitalCalibrationBytes = 338;
inline constexpr int kDigitalCalibrationRegister = 0x00E3;
inline constexpr int kDigitalGainRegister = 0x0000;  // six gains, then six offsets, as active

std::vector<std::uint8_t> rtu_read_holding(int unit, int address, int count);
// Unit 10: 0A 46 55 A3 9D.
std::vector<std::uint8_t> digital_start_stream(int unit);
// True when the last two bytes are the CRC of the others.
[[nodiscard]] bool rtu_frame_is_whole(std::span<const std::uint8_t> frame);

struct DigitalSample {
  std::array<std::int16_t, 6> gauges{};  // G0 to G5
  bool error = false;
  bool operator==(const DigitalSample&) const = default;
};
std::array<std::uint8_t, kDigitalSampleBytes> encode(const DigitalSample& sample);
// Empty when the length is not 13 or the sum is wrong.
[[nodiscard]] std::optional<DigitalSample> decode_digital_sample(std::span<const std::uint8_t> bytes);

struct DigitalCalibration {
  std::string serial;                            // up to 8 characters
  std::string part_number;                       // up to 32
  std::string date;                              // up to 20
  std::array<std::array<float, 6>, 6> matrix{};  // counts of Fx..Tz per gauge count
  std::uint8_t force_unit = 2;                   // 2: N
  std::uint8_t torque_unit = 3;                  // 3: N*m
  std::array<float, 6> range{};                  // in these units
  std::int32_t counts_per_force = 1;
  std::int32_t counts_per_torque = 1;
  std::array<std::uint16_t, 12> gains_and_offsets{};
  bool operator==(const DigitalCalibration&) const = default;
};
std::array<std::uint8_t, kDigitalCalibrationBytes> encode(const DigitalCalibration& calibration);
// Throws Fault TB-FORCE-CALIBRATION: length, unknown units, counts or ranges not above 0, numbers not finite.
// `low_word_first` swaps the two registers of every 32-bit value.
DigitalCalibration decode_digital_calibration(std::span<const std::uint8_t> bytes, bool low_word_first = false);

}  // namespace tactbench::devices
