// Codec of RDT, the Net F/T's data over UDP: bytes to values and back, no I/O. All integers big-endian.
//
// Request, 8 bytes: u16 0x1234, u16 command, u32 sample count (0: until stopped). Never acknowledged.
// Record, 36 bytes: u32 RDT sequence (increments with each record of a stream), u32 F/T sequence (increments with each
//   internal sample), u32 status, i32 Fx Fy Fz Tx Ty Tz in counts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tactbench::devices {

inline constexpr std::size_t kRdtRequestBytes = 8;
inline constexpr std::size_t kRdtRecordBytes = 36;

enum class RdtCommand : std::uint16_t {
  kStop = 0x0000,
  kStartRealtime = 0x0002,
  kStartBuffered = 0x0003,
  kStartMultiUnit = 0x0004,
  kResetLatch = 0x0041,  // the condition latch of the threshold monitors
  kSetBias = 0x0042,     // software bias in the sensor
};

struct RdtRequest {
  RdtCommand command = RdtCommand::kStop;
  std::uint32_t count = 0;
  bool operator==(const RdtRequest&) const = default;
};

struct RdtRecord {
  std::uint32_t rdt_sequence = 0;
  std::uint32_t ft_sequence = 0;
  std::uint32_t status = 0;
  std::array<std::int32_t, 6> counts{};  // Fx, Fy, Fz, Tx, Ty, Tz
  bool operator==(const RdtRecord&) const = default;
};

// Status bits. Any error sets the summary bit; a tripped monitor (bit 16) sets it too, although the data are good.
inline constexpr std::uint32_t kRdtSummary = 1U << 31U;
inline constexpr std::uint32_t kRdtSaturated = 1U << 17U;  // or the A/D converter has failed
inline constexpr std::uint32_t kRdtMonitorTripped = 1U << 16U;

std::array<std::uint8_t, kRdtRequestBytes> encode(const RdtRequest& request);
std::array<std::uint8_t, kRdtRecordBytes> encode(const RdtRecord& record);
// Empty when length, header or command is not as above.
[[nodiscard]] std::optional<RdtRequest> decode_rdt_request(std::span<const std::uint8_t> bytes);
// Empty when the length is not 36.
[[nodiscard]] std::optional<RdtRecord> decode_rdt_record(std::span<const std::uint8_t> bytes);

// True when the status marks the record as unusable: anything but a tripped monitor.
[[nodiscard]] bool rdt_status_is_error(std::uint32_t status);
// Names of the bits set, highest first: "error summary, saturation or A/D error".
[[nodiscard]] std::string rdt_status_text(std::uint32_t status);

}  // namespace tactbench::devices
