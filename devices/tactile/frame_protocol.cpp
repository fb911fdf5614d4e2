#include "devices/tactile/frame_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace tactbench::devices::frame_protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 4> kMagic = {'T', 'B', 'F', 'P'};
constexpr std::uint8_t kSampleU16 = 1;
// In the order of Body's alternatives.
constexpr std::array<std::uint8_t, 8> kTypes = {0x01, 0x02, 0x03, 0x04, 0x81, 0x82, 0x84, 0x8F};
static_assert(kTypes.size() == std::variant_size_v<Body>);

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = (value & 1U) != 0 ? (value >> 1U) ^ 0xEDB88320U : value >> 1U;
    table[byte] = value;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = crc_table();

template <class Integer>
void put(Bytes& bytes, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8U * i) & 0xFFU));
  }
}

void put_text(Bytes& bytes, const std::string& text) {
  bytes.push_back(static_cast<std::uint8_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

// Reads values from the front; `failed` once a value was missing or wrong.
struct PayloadReader {
  std::span<const std::uint8_t> rest;
  bool failed = false;

  template <class Integer>
  Integer get() {
    if (rest.size() < sizeof(Integer)) {
      failed = true;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) value |= static_cast<std::uint64_t>(rest[i]) << (8U * i);
    rest = rest.subspan(sizeof(Integer));
    return static_cast<Integer>(value);
  }
  std::string text() {
    const std::size_t size = get<std::uint8_t>();
    if (rest.size() < size) {
      failed = true;
      return {};
    }
    std::string text(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(size));
    rest = rest.subspan(size);
    return text;
  }
};

// Well-formed UTF-8 (Unicode 15, table 3-7) without control characters: texts go into stores, pages and JSON.
bool good_text(const std::string& text) {
  if (text.size() > kMaxText) return false;
  const auto at = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  for (std::size_t i = 0; i < text.size();) {
    const unsigned first = at(i);
    if (first < 0x20 || (first >= 0x7F && first < 0xC2) || first > 0xF4) return false;
    const std::size_t size = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    const unsigned lowest = first == 0xC2 || first == 0xE0 ? 0xA0U
                            : first == 0xF0                ? 0x90U
                                                           : 0x80U;  // C2 80-9F: control
    const unsigned highest = first == 0xED ? 0x9FU : first == 0xF4 ? 0x8FU : 0xBFU;
    if (size > 1 && (at(i + 1) < lowest || at(i + 1) > highest)) return false;
    for (std::size_t k = 2; k < size; ++k) {
      if ((at(i + k) & 0xC0U) != 0x80U) return false;
    }
    i += size;
  }
  return true;
}

bool good_side(int side) { return side >= 1 && side <= kMaxSide; }

template <class Value>
bool good(const Value&) {
  return true;
}
bool good(const Description& d) {
  return good_side(d.rows) && good_side(d.columns) && std::isfinite(d.volts_per_count) && d.volts_per_count > 0.0 &&
         good_text(d.model) && good_text(d.serial) && good_text(d.firmware);
}
bool good(const Frame& f) {
  return good_side(f.rows) && good_side(f.columns) && f.counts.size() == std::size_t{f.rows} * f.columns;
}
bool good(const Error& e) { return good_text(e.text); }

// Messages without payload.
template <class Empty>
void write(Bytes&, const Empty&) {}
void write(Bytes& bytes, const Identify& i) { put(bytes, i.version); }
void write(Bytes& bytes, const Description& d) {
  put(bytes, d.version);
  put(bytes, d.rows);
  put(bytes, d.columns);
  put(bytes, kSampleU16);
  put(bytes, std::uint8_t{0});
  put(bytes, std::bit_cast<std::uint64_t>(d.volts_per_count));
  for (const std::string* text : {&d.model, &d.serial, &d.firmware}) put_text(bytes, *text);
}
void write(Bytes& bytes, const Frame& f) {
  put(bytes, f.device_time_us);
  put(bytes, f.counter);
  put(bytes, f.rows);
  put(bytes, f.columns);
  put(bytes, f.status);
  put(bytes, std::uint8_t{0});
  for (const std::uint16_t count : f.counts) put(bytes, count);
}
void write(Bytes& bytes, const Error& e) {
  put(bytes, static_cast<std::uint16_t>(e.code));
  put_text(bytes, e.text);
}

template <class Empty>
void read(PayloadReader&, Empty&) {}
void read(PayloadReader& in, Identify& i) { i.version = in.get<std::uint16_t>(); }
void read(PayloadReader& in, Description& d) {
  d.version = in.get<std::uint16_t>();
  d.rows = in.get<std::uint16_t>();
  d.columns = in.get<std::uint16_t>();
  if (in.get<std::uint8_t>() != kSampleU16 || in.get<std::uint8_t>() != 0) in.failed = true;
  d.volts_per_count = std::bit_cast<double>(in.get<std::uint64_t>());
  for (std::string* text : {&d.model, &d.serial, &d.firmware}) *text = in.text();
}
void read(PayloadReader& in, Frame& f) {
  f.device_time_us = in.get<std::uint64_t>();
  f.counter = in.get<std::uint32_t>();
  f.rows = in.get<std::uint16_t>();
  f.columns = in.get<std::uint16_t>();
  f.status = in.get<std::uint8_t>();
  if (in.get<std::uint8_t>() != 0 || in.rest.size() != 2 * std::size_t{f.rows} * f.columns) in.failed = true;
  if (in.failed) return;
  f.counts.resize(in.rest.size() / 2);
  for (std::uint16_t& count : f.counts) count = in.get<std::uint16_t>();
}
void read(PayloadReader& in, Error& e) {
  e.code = static_cast<ErrorCode>(in.get<std::uint16_t>());
  e.text = in.text();
}

template <std::size_t... kIndex>
Body empty_body(std::size_t index, std::index_sequence<kIndex...>) {
  Body body;
  (void)((index == kIndex && (body.emplace<kIndex>(), true)) || ...);
  return body;
}

std::uint64_t little(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | bytes[i];
  return value;
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) crc = crc >> 8U ^ kCrcTable[(crc ^ byte) & 0xFFU];
  return ~crc;
}

std::vector<std::uint8_t> encode(const Message& message) {
  if (!std::visit([](const auto& body) { return good(body); }, message.body)) {
    throw std::invalid_argument(
        "a frame-source message exceeds a bound of the protocol (sides, counts, scale or text)");
  }
  Bytes payload;
  std::visit([&](const auto& body) { write(payload, body); }, message.body);
  Bytes bytes(kMagic.begin(), kMagic.end());
  put(bytes, kTypes[message.body.index()]);
  put(bytes, std::uint8_t{0});
  put(bytes, message.tag);
  put(bytes, static_cast<std::uint32_t>(payload.size()));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  put(bytes, crc32(bytes));
  return bytes;
}

bool known_type(std::uint8_t type) { return std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end(); }

std::optional<Message> decode(const Packet& packet) {
  const auto type = std::find(kTypes.begin(), kTypes.end(), packet.type);
  if (type == kTypes.end()) return std::nullopt;
  Message message{packet.tag, empty_body(static_cast<std::size_t>(type - kTypes.begin()),
                                         std::make_index_sequence<std::variant_size_v<Body>>{})};
  PayloadReader in{packet.payload};
  const bool sound = std::visit(
      [&](auto& body) {
        read(in, body);
        return !in.failed && in.rest.empty() && good(body);
      },
      message.body);
  if (!sound) return std::nullopt;
  return message;
}

void Parser::feed(std::span<const std::uint8_t> bytes) {
  if (!broken_.empty()) return;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ = 0;
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

std::optional<Packet> Parser::next() {
  const auto rest = std::span<const std::uint8_t>(waiting_).subspan(used_);
  const std::size_t seen = std::min(rest.size(), kMagic.size());
  if (!broken_.empty()) return std::nullopt;
  if (!std::equal(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(seen), kMagic.begin())) broken_ = "magic";
  if (!broken_.empty() || rest.size() < kHeaderBytes) return std::nullopt;
  const std::uint64_t size = little(rest.subspan(8, 4));
  if (size > kMaxPayload) broken_ = fmt::format("payload of {} bytes (up to {})", size, kMaxPayload);
  if (rest[5] != 0) broken_ = "reserved byte";
  if (!broken_.empty() || rest.size() < kHeaderBytes + size + kChecksumBytes) return std::nullopt;
  const auto covered = rest.first(kHeaderBytes + size);
  if (little(rest.subspan(covered.size(), kChecksumBytes)) != crc32(covered)) {
    broken_ = "CRC";
    return std::nullopt;
  }
  used_ += covered.size() + kChecksumBytes;
  const auto payload = covered.subspan(kHeaderBytes);
  return Packet{rest[4], static_cast<std::uint16_t>(little(rest.subspan(6, 2))), {payload.begin(), payload.end()}};
}

}  // namespace tactbench::devices::frame_protocol
