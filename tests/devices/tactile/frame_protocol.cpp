#include "devices/tactile/frame_protocol.h"

#include <catch2/catch.hpp>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::devices::frame_protocol;
using Bytes = std::vector<std::uint8_t>;

namespace {

Frame frame_of(std::uint16_t rows, std::uint16_t columns) {
  Frame frame{77, 5, 1, rows, columns, {}};
  for (std::size_t i = 0; i < std::size_t{rows} * columns; ++i)
    frame.counts.push_back(static_cast<std::uint16_t>(i * 7));
  return frame;
}

const std::vector<Message>& one_of_each() {
  static const std::vector<Message> kMessages = {
      {1, Identify{}},
      {2, Scan{}},
      {3, Subscribe{}},
      {4, Unsubscribe{}},
      {1, Description{1, 2, 3, 1e-4, "M", "S-7", "1.0"}},
      {2, Frame{1'500'000, 41, 2, 2, 3, {1, 2, 3, 258, 65535, 0}}},
      {4, Done{}},
      {9, Error{ErrorCode::kUnknownType, "no"}},
  };
  return kMessages;
}

// The examples in the document, in its order.
std::vector<Bytes> documented() {
  const auto text = tactbench::tests::read_file(tactbench::tests::source_path("devices/tactile/frame_protocol.md"));
  const std::size_t begin = text.find("```hex\n") + 7;
  std::istringstream lines(text.substr(begin, text.find("```", begin) - begin));
  std::vector<Bytes> examples;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  ")) {
      examples.emplace_back();
      continue;
    }
    std::istringstream words(line);
    for (unsigned byte = 0; words >> std::hex >> byte;) examples.back().push_back(static_cast<std::uint8_t>(byte));
  }
  return examples;
}

Packet packet_of(const Message& message) {
  Parser parser;
  parser.feed(encode(message));
  return parser.next().value();
}

// `bytes` with a CRC that fits them.
Bytes sealed(Bytes bytes) {
  bytes.erase(bytes.end() - kChecksumBytes, bytes.end());
  const std::uint32_t crc = crc32(bytes);
  for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i) & 0xFFU));
  return bytes;
}

bool breaks(const Bytes& bytes) {
  Parser parser;
  parser.feed(bytes);
  CHECK_FALSE(parser.next());
  parser.feed(encode({1, Scan{}}));
  CHECK_FALSE(parser.next());  // for good
  return !parser.broken().empty();
}

}  // namespace

TEST_CASE("frame protocol: CRC-32 check value") {
  const std::string digits = "123456789";
  CHECK(crc32(Bytes(digits.begin(), digits.end())) == 0xCBF43926U);
}

TEST_CASE("frame protocol: the document's bytes are the codec's, both ways") {
  const auto examples = documented();
  REQUIRE(examples.size() == one_of_each().size());
  for (std::size_t i = 0; i < examples.size(); ++i) {
    INFO("example " << i);
    CHECK(examples[i] == encode(one_of_each()[i]));
    Parser parser;
    parser.feed(examples[i]);
    const auto packet = parser.next();
    REQUIRE(packet);
    CHECK(decode(*packet) == one_of_each()[i]);
  }
}

TEST_CASE("frame protocol: messages are cut from a stream however it arrives") {
  Bytes stream;
  for (const Message& message : one_of_each()) {
    const auto bytes = encode(message);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  for (const std::size_t piece : {std::size_t{1}, std::size_t{5}, std::size_t{13}, stream.size()}) {
    Parser parser;
    std::vector<Message> came;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      parser.feed(std::span(stream).subspan(at, std::min(piece, stream.size() - at)));
      while (const auto packet = parser.next()) came.push_back(decode(*packet).value());
    }
    CHECK(came == one_of_each());
    CHECK(parser.broken().empty());
  }
}

TEST_CASE("frame protocol: the largest and the smallest frame") {
  for (const auto& frame : {frame_of(256, 256), frame_of(1, 1), frame_of(1, 256)}) {
    CHECK(decode(packet_of({65535, frame})) == Message{65535, frame});
  }
  CHECK(packet_of({0, frame_of(256, 256)}).payload.size() == kMaxPayload);
}

TEST_CASE("frame protocol: every flipped bit is detected") {
  for (const Message& message : one_of_each()) {
    const auto sound = encode(message);
    for (std::size_t bit = 0; bit < 8 * sound.size(); ++bit) {
      auto damaged = sound;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << bit % 8));
      Parser parser;
      parser.feed(damaged);
      const auto packet = parser.next();
      // A longer length waits for further bytes; every other flip is detected at once.
      const bool length = bit / 8 >= 8 && bit / 8 < 12;
      if (packet || (parser.broken().empty() && !length)) FAIL("bit " << bit << " of type " << int{sound[4]});
    }
  }
}

TEST_CASE("frame protocol: a stream breaks for good") {
  auto magic = encode({1, Scan{}});
  magic[3] = 'Q';
  CHECK(breaks(magic));
  CHECK(breaks({'G', 'E', 'T'}));
  auto reserved = encode({1, Scan{}});
  reserved[5] = 1;
  CHECK(breaks(sealed(reserved)));
  auto checksum = encode({1, Scan{}});
  checksum.back() ^= 1U;
  CHECK(breaks(checksum));
  auto length = encode({1, Scan{}});
  length[10] = 2;
  length[8] = 0x13;
  CHECK(breaks(length));  // refused on its header, before the bytes come
}

TEST_CASE("frame protocol: intact packets with a wrong payload are not messages") {
  CHECK_FALSE(decode(Packet{0x55, 1, {}}));
  CHECK_FALSE(known_type(0x55));
  CHECK(known_type(0x82));
  for (const Message& message : one_of_each()) {
    auto packet = packet_of(message);
    packet.payload.push_back(0);
    CHECK_FALSE(decode(packet));
    packet.payload.pop_back();
    if (packet.payload.empty()) continue;
    packet.payload.pop_back();
    CHECK_FALSE(decode(packet));
  }
  const auto spoilt = [](const Message& message, std::size_t at, std::uint8_t value) {
    auto packet = packet_of(message);
    packet.payload[at] = value;
    return decode(packet).has_value();
  };
  const Message description = one_of_each()[4];
  const Message frame = one_of_each()[5];
  CHECK(spoilt(description, 2, 9));
  CHECK_FALSE(spoilt(description, 2, 0));      // rows
  CHECK_FALSE(spoilt(description, 5, 2));      // columns 515
  CHECK_FALSE(spoilt(description, 6, 2));      // sample type
  CHECK_FALSE(spoilt(description, 7, 1));      // reserved
  CHECK_FALSE(spoilt(description, 15, 0xFF));  // volts per count below 0
  CHECK_FALSE(spoilt(description, 17, '\n'));  // model
  CHECK_FALSE(spoilt(description, 16, 200));   // its size
  CHECK_FALSE(spoilt(frame, 12, 3));           // rows
  CHECK_FALSE(spoilt(frame, 17, 1));           // reserved
}
