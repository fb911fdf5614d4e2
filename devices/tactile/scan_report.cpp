#include "devices/tactile/scan_report.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace tactbench::devices {
namespace {

constexpr std::size_t kTextBytes = 16;
constexpr std::size_t kSamplesAt = 15;

constexpr std::array<std::uint16_t, 256> crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned value = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) value = (value & 0x8000U) != 0 ? (value << 1U) ^ 0x1021U : value << 1U;
    table[byte] = static_cast<std::uint16_t>(value & 0xFFFFU);
  }
  return table;
}

constexpr std::array<std::uint16_t, 256> kCrcTable = crc_table();

void put16(std::span<std::uint8_t> bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value & 0xFFU);
  bytes[at + 1] = static_cast<std::uint8_t>(value >> 8U);
}

void put32(std::span<std::uint8_t> bytes, std::size_t at, std::uint32_t value) {
  put16(bytes, at, static_cast<std::uint16_t>(value & 0xFFFFU));
  put16(bytes, at + 2, static_cast<std::uint16_t>(value >> 16U));
}

std::uint16_t get16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8U);
}

std::uint32_t get32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return get16(bytes, at) | static_cast<std::uint32_t>(get16(bytes, at + 2)) << 16U;
}

void put_text(std::span<std::uint8_t> bytes, std::size_t at, const std::string& text) {
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (text.size() > kTextBytes || !printable) {
    throw std::invalid_argument("a scanner's serial and firmware have up to 16 ASCII characters: '" + text + "'");
  }
  std::copy(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

// Empty when a character is not printable or something follows the padding.
std::optional<std::string> get_text(std::span<const std::uint8_t> bytes, std::size_t at) {
  const auto field = bytes.subspan(at, kTextBytes);
  const auto end = std::find(field.begin(), field.end(), 0);
  const bool padded = std::all_of(end, field.end(), [](std::uint8_t c) { return c == 0; });
  const bool printable = std::all_of(field.begin(), end, [](std::uint8_t c) { return c >= ' ' && c <= '~'; });
  if (!padded || !printable) return std::nullopt;
  return std::string(field.begin(), end);
}

bool zeros(std::span<const std::uint8_t> bytes, std::size_t from, std::size_t to) {
  return std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.begin() + static_cast<std::ptrdiff_t>(to),
                     [](std::uint8_t byte) { return byte == 0; });
}

// The CRC is in the last two bytes and covers all bytes before it.
void seal(std::span<std::uint8_t> bytes) { put16(bytes, bytes.size() - 2, crc16_ccitt(bytes.first(bytes.size() - 2))); }

bool intact(std::span<const std::uint8_t> bytes, std::size_t size, std::uint8_t id) {
  return bytes.size() == size && bytes[0] == id && get16(bytes, size - 2) == crc16_ccitt(bytes.first(size - 2));
}

}  // namespace

std::uint16_t crc16_ccitt(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFFU;
  for (const std::uint8_t byte : bytes) crc = ((crc << 8U) & 0xFFFFU) ^ kCrcTable[(crc >> 8U) ^ byte];
  return static_cast<std::uint16_t>(crc);
}

std::array<std::uint8_t, kScanCommandBytes> encode(const CommandReport& report) {
  std::array<std::uint8_t, kScanCommandBytes> bytes{};
  bytes[0] = kCommandId;
  bytes[1] = static_cast<std::uint8_t>(report.command);
  put16(bytes, 2, report.tag);
  seal(bytes);
  return bytes;
}

std::array<std::uint8_t, kScanReportBytes> encode(const RowReport& report) {
  std::array<std::uint8_t, kScanReportBytes> bytes{};
  bytes[0] = kRowId;
  put16(bytes, 1, report.sequence);
  put32(bytes, 3, report.frame);
  put16(bytes, 7, report.tag);
  bytes[9] = report.row;
  bytes[10] = report.status;
  put32(bytes, 11, report.device_time_us);
  for (std::size_t i = 0; i < report.samples.size(); ++i) put16(bytes, kSamplesAt + 2 * i, report.samples[i]);
  seal(bytes);
  return bytes;
}

std::array<std::uint8_t, kScanReportBytes> encode(const IdentityReport& report) {
  std::array<std::uint8_t, kScanReportBytes> bytes{};
  bytes[0] = kIdentityId;
  put16(bytes, 1, report.tag);
  bytes[3] = report.rows;
  bytes[4] = report.columns;
  put32(bytes, 5, std::bit_cast<std::uint32_t>(report.volts_per_count));
  put_text(bytes, 9, report.serial);
  put_text(bytes, 25, report.firmware);
  seal(bytes);
  return bytes;
}

std::optional<CommandReport> decode_command(std::span<const std::uint8_t> bytes) {
  if (!intact(bytes, kScanCommandBytes, kCommandId) || !zeros(bytes, 4, 6)) return std::nullopt;
  const auto command = static_cast<ScanCommand>(bytes[1]);
  if (command != ScanCommand::kScan && command != ScanCommand::kIdentify) return std::nullopt;
  return CommandReport{command, get16(bytes, 2)};
}

std::optional<RowReport> decode_row(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kSamplesEnd = kSamplesAt + 2 * std::size_t{kScanColumns};
  if (!intact(bytes, kScanReportBytes, kRowId) || !zeros(bytes, kSamplesEnd, kScanReportBytes - 2)) return std::nullopt;
  RowReport report;
  report.sequence = get16(bytes, 1);
  report.frame = get32(bytes, 3);
  report.tag = get16(bytes, 7);
  report.row = bytes[9];
  report.status = bytes[10];
  report.device_time_us = get32(bytes, 11);
  for (std::size_t i = 0; i < report.samples.size(); ++i) report.samples[i] = get16(bytes, kSamplesAt + 2 * i);
  return report;
}

std::optional<IdentityReport> decode_identity(std::span<const std::uint8_t> bytes) {
  if (!intact(bytes, kScanReportBytes, kIdentityId) || !zeros(bytes, 41, kScanReportBytes - 2)) return std::nullopt;
  const auto serial = get_text(bytes, 9);
  const auto firmware = get_text(bytes, 25);
  if (!serial || !firmware) return std::nullopt;
  return IdentityReport{get16(bytes, 1), bytes[3], bytes[4], std::bit_cast<float>(get32(bytes, 5)), *serial, *firmware};
}

}  // namespace tactbench::devices
