#include "devices/force/rdt_record.h"

namespace tactbench::devices {
namespace {

constexpr std::uint32_t kHeader = 0x1234;

// From bit 0 on; empty: no source names this bit.
constexpr std::array<const char*, 32> kBitNames{"",
                                                "HTTP",
                                                "temperature",
                                                "reference voltage",
                                                "link data",
                                                "supply low",
                                                "supply high",
                                                "ground",
                                                "excitation low",
                                                "excitation high",
                                                "analog watchdog",
                                                "flash memory",
                                                "EEPROM",
                                                "stack",
                                                "watchdog",
                                                "",
                                                "monitor condition latched",
                                                "saturation or A/D error",
                                                "DeviceNet",
                                                "EtherNet/IP",
                                                "RDT",
                                                "CAN",
                                                "network",
                                                "configuration against calibration",
                                                "settings",
                                                "halted by configuration",
                                                "program memory",
                                                "serial link",
                                                "analog board",
                                                "digital board",
                                                "CPU or RAM",
                                                "error summary"};

void put(std::span<std::uint8_t> bytes, std::size_t at, std::size_t size, std::uint32_t value) {
  for (std::size_t i = size; i-- > 0; value >>= 8U) bytes[at + i] = static_cast<std::uint8_t>(value & 0xFFU);
}

std::uint32_t get(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8U | bytes[at + i];
  return value;
}

}  // namespace

std::array<std::uint8_t, kRdtRequestBytes> encode(const RdtRequest& request) {
  std::array<std::uint8_t, kRdtRequestBytes> bytes{};
  put(bytes, 0, 2, kHeader);
  put(bytes, 2, 2, static_cast<std::uint32_t>(request.command));
  put(bytes, 4, 4, request.count);
  return bytes;
}

std::array<std::uint8_t, kRdtRecordBytes> encode(const RdtRecord& record) {
  std::array<std::uint8_t, kRdtRecordBytes> bytes{};
  put(bytes, 0, 4, record.rdt_sequence);
  put(bytes, 4, 4, record.ft_sequence);
  put(bytes, 8, 4, record.status);
  for (std::size_t i = 0; i < 6; ++i) put(bytes, 12 + 4 * i, 4, static_cast<std::uint32_t>(record.counts[i]));
  return bytes;
}

std::optional<RdtRequest> decode_rdt_request(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kRdtRequestBytes || get(bytes, 0, 2) != kHeader) return std::nullopt;
  const RdtRequest request{static_cast<RdtCommand>(get(bytes, 2, 2)), get(bytes, 4, 4)};
  switch (request.command) {
    case RdtCommand::kStop:
    case RdtCommand::kStartRealtime:
    case RdtCommand::kStartBuffered:
    case RdtCommand::kStartMultiUnit:
    case RdtCommand::kResetLatch:
    case RdtCommand::kSetBias:
      return request;
  }
  return std::nullopt;
}

std::optional<RdtRecord> decode_rdt_record(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kRdtRecordBytes) return std::nullopt;
  RdtRecord record{get(bytes, 0, 4), get(bytes, 4, 4), get(bytes, 8, 4), {}};
  for (std::size_t i = 0; i < 6; ++i) record.counts[i] = static_cast<std::int32_t>(get(bytes, 12 + 4 * i, 4));
  return record;
}

bool rdt_status_is_error(std::uint32_t status) {
  if ((status & ~(kRdtSummary | kRdtMonitorTripped)) != 0) return true;
  return status == kRdtSummary;  // an error that no bit names
}

std::string rdt_status_text(std::uint32_t status) {
  std::string text;
  for (std::size_t bit = kBitNames.size(); bit-- > 0;) {
    if ((status >> bit & 1U) == 0) continue;
    if (!text.empty()) text += ", ";
    text += *kBitNames[bit] != '\0' ? std::string(kBitNames[bit]) : "bit " + std::to_string(bit);
  }
  return text.empty() ? "healthy" : text;
}

}  // namespace tactbench::devices
