// Codec of the frame-source protocol, which connects any laboratory's scanner over a byte stream (TCP): bytes to values
// and back, no I/O. frame_protocol.md is the specification; its example bytes are tested against this.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace tactbench::devices::frame_protocol {

inline constexpr std::uint16_t kVersion = 1;
inline constexpr int kMaxSide = 256;  // rows, and columns
inline constexpr std::size_t kMaxText = 255;
inline constexpr std::size_t kHeaderBytes = 12;
inline constexpr std::size_t kChecksumBytes = 4;
inline constexpr std::size_t kMaxPayload = 18 + 2 * std::size_t{kMaxSide} * kMaxSide;  // a frame of 256 x 256

struct Identify {  // client: asks for the source's description
  std::uint16_t version = kVersion;
  bool operator==(const Identify&) const = default;
};
struct Scan {  // client: asks for one fresh frame
  bool operator==(const Scan&) const = default;
};
struct Subscribe {  // client: frames at the source's own rate until Unsubscribe
  bool operator==(const Subscribe&) const = default;
};
struct Unsubscribe {
  bool operator==(const Unsubscribe&) const = default;
};
struct Description {  // source, to Identify
  std::uint16_t version = kVersion;
  std::uint16_t rows = 0, columns = 0;  // 1 to kMaxSide
  double volts_per_count = 0.0;         // finite, above 0
  std::string model, serial, firmware;  // UTF-8 without control characters, up to kMaxText bytes each
  bool operator==(const Description&) const = default;
};
struct Frame {  // source, to Scan, and repeatedly to Subscribe
  std::uint64_t device_time_us = 0;
  std::uint32_t counter = 0;  // increments with each frame that the source has made, for any client; wraps
  std::uint8_t status = 0;    // bits as in scan_report.h
  std::uint16_t rows = 0, columns = 0;
  std::vector<std::uint16_t> counts;  // rows x columns, row-major
  bool operator==(const Frame&) const = default;
};
struct Done {  // source, to Unsubscribe: no further frames follow
  bool operator==(const Done&) const = default;
};
enum class ErrorCode : std::uint16_t {
  kDamaged = 1,
  kUnknownType = 2,
  kBadPayload = 3,
  kOtherVersion = 4,
  kDevice = 5
};
struct Error {
  ErrorCode code = ErrorCode::kDevice;  // other values are passed on unchanged
  std::string text;
  bool operator==(const Error&) const = default;
};

using Body = std::variant<Identify, Scan, Subscribe, Unsubscribe, Description, Frame, Done, Error>;
struct Message {
  std::uint16_t tag = 0;  // chosen by the client; each answer carries that of its request
  Body body;
  bool operator==(const Message&) const = default;
};

// CRC-32 of zlib and Ethernet: polynomial 0x04C11DB7 (reflected 0xEDB88320), start and final exclusive-or 0xFFFFFFFF;
// check value of "123456789" is 0xCBF43926.
std::uint32_t crc32(std::span<const std::uint8_t> bytes);

// Throws std::invalid_argument when the body exceeds a bound above.
std::vector<std::uint8_t> encode(const Message& message);

// A message whose frame, length and CRC are sound; its type may be unknown and its payload wrong.
struct Packet {
  std::uint8_t type = 0;
  std::uint16_t tag = 0;
  std::vector<std::uint8_t> payload;
};
[[nodiscard]] bool known_type(std::uint8_t type);
// Empty when the type is unknown or the payload does not fit it.
[[nodiscard]] std::optional<Message> decode(const Packet& packet);

// Cuts a byte stream into packets, however the bytes arrive. A wrong magic number, length or CRC breaks the stream
// permanently: later bytes cannot be trusted, so the connection must be closed. Never holds more than was fed to it.
class Parser {
 public:
  void feed(std::span<const std::uint8_t> bytes);
  // The next complete packet; empty: more bytes are needed, or the stream is broken.
  [[nodiscard]] std::optional<Packet> next();
  // The stream's error, e.g. "CRC"; empty: none.
  [[nodiscard]] const std::string& broken() const { return broken_; }

 private:
  std::vector<std::uint8_t> waiting_;
  std::size_t used_ = 0;
  std::string broken_;
};

}  // namespace tactbench::devices::frame_protocol
