// Codec of the HID scanner's reports: bytes to values and back, no I/O. All integers little-endian.
//
// Output report 0x02, 8 bytes: id, command (1 scan, 2 identify), u16 tag, u16 reserved 0, u16 CRC of bytes 0-5.
//   One scan command is answered by `rows` input reports 0x01; identify by one input report 0x03.
// Input report 0x01 (one row of one scan), 64 bytes: id, u16 sequence (increments with each report, wraps), u32 frame
//   counter, u16 tag of the command answered, u8 row, u8 status, u32 device time in us, 16 x u16 samples (bytes
//   15-46), 15 bytes 0, u16 CRC of bytes 0-61.
// Input report 0x03 (identity), 64 bytes: id, u16 tag, u8 rows, u8 columns, f32 volts per count, 16 bytes serial,
//   16 bytes firmware (both NUL padded ASCII), zeros, u16 CRC of bytes 0-61.
// Status bits: 0 a sample at the converter's limit, 1 row relay did not settle, 2 supply out of range.
// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF; check value of "123456789" is 0x29B1.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tactbench::devices {

inline constexpr std::size_t kScanReportBytes = 64;
inline constexpr std::size_t kScanCommandBytes = 8;
inline constexpr int kScanColumns = 16;
inline constexpr std::uint8_t kRowId = 0x01, kCommandId = 0x02, kIdentityId = 0x03;
inline constexpr std::uint8_t kStatusAtLimit = 1U << 0;
inline constexpr std::uint8_t kStatusNotSettled = 1U << 1;
inline constexpr std::uint8_t kStatusSupply = 1U << 2;

enum class ScanCommand : std::uint8_t { kScan = 1, kIdentify = 2 };

struct CommandReport {
  ScanCommand command = ScanCommand::kScan;
  std::uint16_t tag = 0;
  bool operator==(const CommandReport&) const = default;
};

struct RowReport {
  std::uint16_t sequence = 0;
  std::uint32_t frame = 0;
  std::uint16_t tag = 0;
  std::uint8_t row = 0;
  std::uint8_t status = 0;
  std::uint32_t device_time_us = 0;
  std::array<std::uint16_t, kScanColumns> samples{};
  bool operator==(const RowReport&) const = default;
};

struct IdentityReport {
  std::uint16_t tag = 0;
  std::uint8_t rows = 0;
  std::uint8_t columns = 0;
  float volts_per_count = 0.0F;
  std::string serial;    // up to 16 ASCII characters
  std::string firmware;  // up to 16
  bool operator==(const IdentityReport&) const = default;
};

std::uint16_t crc16_ccitt(std::span<const std::uint8_t> bytes);

std::array<std::uint8_t, kScanCommandBytes> encode(const CommandReport& report);
std::array<std::uint8_t, kScanReportBytes> encode(const RowReport& report);
std::array<std::uint8_t, kScanReportBytes> encode(const IdentityReport& report);

// Empty when length, id, padding or CRC is wrong.
[[nodiscard]] std::optional<CommandReport> decode_command(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::optional<RowReport> decode_row(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::optional<IdentityReport> decode_identity(std::span<const std::uint8_t> bytes);

}  // namespace tactbench::devices
