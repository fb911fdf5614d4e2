#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "devices/tactile/frame_protocol.h"
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

Packet packet_from(const Bytes& bytes) {
  Parser parser;
  parser.feed(bytes);
  const auto packet = parser.next();
  REQUIRE(packet);
  return *packet;
}
Packet packet_of(const Message& message) { return packet_from(encode(message)); }

}  // namespace

TEST_CASE("frame protocol: CRC-32 has its published check value") {
  const std::string digits = "123456789";
  CHECK(crc32(Bytes(digits.begin(), digits.end())) == 0xCBF43926U);
}

TEST_CASE("frame protocol: messages encode to and decode from the bytes in the protocol document") {
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

TEST_CASE("frame protocol: messages are found in a stream, however it is split") {
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

TEST_CASE("frame protocol: the largest and the smallest frame survive encoding and decoding") {
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

TEST_CASE("frame protocol: a damaged stream stays unusable") {
  auto checksum = encode({1, Scan{}});
  checksum.back() ^= 1U;
  for (const Bytes& bytes : {checksum, Bytes{'G', 'E', 'T'}}) {
    Parser parser;
    parser.feed(bytes);
    CHECK_FALSE(parser.next());
    parser.feed(encode({1, Scan{}}));
    CHECK_FALSE(parser.next());
    CHECK_FALSE(parser.broken().empty());
  }
}

TEST_CASE("frame protocol: intact packets with an invalid payload do not decode") {
  CHECK_FALSE(decode(Packet{0x55, 1, {}}));
  for (const Message& message : one_of_each()) {
    auto packet = packet_of(message);
    packet.payload.push_back(0);
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

namespace {

bool is_sound(std::uint8_t type, const Bytes& payload) { return decode(Packet{type, 1, payload}).has_value(); }

// Whether a text passes both ways, put between plain letters.
bool passes(const std::string& text) {
  const std::string whole = "a" + text + "z";
  Bytes payload{5, 0, static_cast<std::uint8_t>(whole.size())};
  payload.insert(payload.end(), whole.begin(), whole.end());
  const auto read = decode(Packet{0x8F, 1, payload});
  bool written = true;
  try {
    const auto bytes = encode({1, Error{ErrorCode::kDevice, whole}});
    CHECK(packet_from(bytes).payload == payload);
  } catch (const std::invalid_argument&) {
    written = false;
  }
  CHECK(written == read.has_value());
  if (read) CHECK(std::get<Error>(read->body).text == whole);
  return read.has_value();
}

std::string text_of(const std::vector<int>& bytes) {
  std::string text;
  for (const int byte : bytes) text.push_back(static_cast<char>(byte));
  return text;
}

// A row of table 3-7 of the Unicode standard: the lowest and highest byte at each place.
using Ranges = std::vector<std::pair<int, int>>;

}  // namespace

TEST_CASE("frame protocol: a payload cut at any byte does not decode") {
  const std::vector<Message> messages = {{1, Identify{}},
                                         {1, Description{1, 2, 3, 1e-4, "M", "S-7", "1.0"}},
                                         {1, Description{1, 2, 3, 1e-4, "", "", ""}},
                                         {2, Frame{1, 41, 2, 1, 2, {0, 0}}},
                                         {9, Error{ErrorCode::kDevice, ""}},
                                         {9, Error{ErrorCode::kDevice, "no"}}};
  for (const Message& message : messages) {
    const Packet whole = packet_of(message);
    CHECK(decode(whole) == message);
    for (std::size_t size = 0; size < whole.payload.size(); ++size) {
      INFO(size << " of " << whole.payload.size() << " bytes of type " << int{whole.type});
      const auto begin = whole.payload.begin();
      CHECK_FALSE(is_sound(whole.type, {begin, begin + static_cast<std::ptrdiff_t>(size)}));
    }
  }
  CHECK_FALSE(is_sound(0x8F, {0}));  // half a code, and no text
}

TEST_CASE(
    "frame protocol: a text longer than its payload does not decode, even if the bytes would fit the next texts") {
  const Bytes front{1, 0, 2, 0, 3, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
  const auto with = [&](const Bytes& texts) {
    Bytes payload = front;
    payload.insert(payload.end(), texts.begin(), texts.end());
    return is_sound(0x81, payload);
  };
  CHECK(with({1, 'm', 1, 's', 1, 'f'}));
  CHECK(with({0, 1, 's', 1, 'f'}));
  CHECK_FALSE(with({5, 1, 's', 1, 'f'}));
  CHECK_FALSE(with({4, 1, 's', 1, 'f'}));
  CHECK_FALSE(with({0, 1, 's', 2, 'f'}));
}

TEST_CASE("frame protocol: UTF-8 is accepted at both edges of each byte range, and refused just outside") {
  // Table 3-7, with the control characters 00 to 1F, 7F and C2 80 to C2 9F taken out.
  const std::vector<Ranges> rows = {{{0x20, 0x7E}},
                                    {{0xC2, 0xC2}, {0xA0, 0xBF}},
                                    {{0xC3, 0xDF}, {0x80, 0xBF}},
                                    {{0xE0, 0xE0}, {0xA0, 0xBF}, {0x80, 0xBF}},
                                    {{0xE1, 0xEC}, {0x80, 0xBF}, {0x80, 0xBF}},
                                    {{0xED, 0xED}, {0x80, 0x9F}, {0x80, 0xBF}},
                                    {{0xEE, 0xEF}, {0x80, 0xBF}, {0x80, 0xBF}},
                                    {{0xF0, 0xF0}, {0x90, 0xBF}, {0x80, 0xBF}, {0x80, 0xBF}},
                                    {{0xF1, 0xF3}, {0x80, 0xBF}, {0x80, 0xBF}, {0x80, 0xBF}},
                                    {{0xF4, 0xF4}, {0x80, 0x8F}, {0x80, 0xBF}, {0x80, 0xBF}}};
  for (const Ranges& row : rows) {
    std::vector<int> lowest, highest;
    for (const auto& [low, high] : row) {
      lowest.push_back(low);
      highest.push_back(high);
    }
    INFO("from " << std::hex << lowest[0]);
    CHECK(passes(text_of(lowest)));
    CHECK(passes(text_of(highest)));
    for (std::size_t place = 1; place < row.size(); ++place) {
      INFO("place " << place);
      std::vector<int> bytes = highest;
      bytes[place] = row[place].first;
      CHECK(passes(text_of(bytes)));
      bytes[place] = row[place].first - 1;
      CHECK_FALSE(passes(text_of(bytes)));
      bytes = lowest;
      bytes[place] = row[place].second;
      CHECK(passes(text_of(bytes)));
      bytes[place] = row[place].second + 1;
      CHECK_FALSE(passes(text_of(bytes)));
      CHECK_FALSE(passes(text_of({lowest.begin(), lowest.begin() + static_cast<std::ptrdiff_t>(place)})));
    }
  }
  for (const int alone : {0x00, 0x1F, 0x7F, 0x80, 0x9F, 0xBF, 0xC0, 0xC1, 0xF5, 0xFF}) {
    CHECK_FALSE(passes(text_of({alone})));
    CHECK_FALSE(passes(text_of({alone, 0x80, 0x80, 0x80})));
  }
  CHECK(passes(std::string(253, 'x')));
  CHECK_THROWS_AS(encode({1, Error{ErrorCode::kDevice, std::string(256, 'x')}}), std::invalid_argument);
  // Every text of a description is judged, to its last character.
  for (const char* bad : {"\n", "ab\n", "\xE2\x82\xAC\x7F"}) {
    CHECK_THROWS_AS(encode({1, Description{1, 1, 1, 1.0, bad, "", ""}}), std::invalid_argument);
    CHECK_THROWS_AS(encode({1, Description{1, 1, 1, 1.0, "", bad, ""}}), std::invalid_argument);
    CHECK_THROWS_AS(encode({1, Description{1, 1, 1, 1.0, "", "", bad}}), std::invalid_argument);
  }
}

TEST_CASE("frame protocol: accepts 1 to 256 rows and columns with matching counts, and scales above 0") {
  const auto encoded = [](const Body& body) {
    try {
      (void)encode({1, body});
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  const auto described = [&](unsigned rows, unsigned columns, double scale) {
    return encoded(
        Description{1, static_cast<std::uint16_t>(rows), static_cast<std::uint16_t>(columns), scale, "", "", ""});
  };
  CHECK((described(1, 256, 1.0) && described(256, 1, 1.0)));
  CHECK_FALSE((described(0, 1, 1.0) || described(1, 0, 1.0) || described(257, 1, 1.0) || described(1, 257, 1.0)));
  CHECK((described(1, 1, 1e-300) && described(1, 1, std::numeric_limits<double>::denorm_min()) &&
         described(1, 1, 1e300)));
  CHECK_FALSE((described(1, 1, 0.0) || described(1, 1, -1e-300)));
  CHECK_FALSE((described(1, 1, std::numeric_limits<double>::quiet_NaN()) ||
               described(1, 1, std::numeric_limits<double>::infinity())));
  const auto framed = [&](unsigned rows, unsigned columns, std::size_t counts) {
    return encoded(Frame{0, 0, 0, static_cast<std::uint16_t>(rows), static_cast<std::uint16_t>(columns),
                         std::vector<std::uint16_t>(counts)});
  };
  CHECK((framed(2, 3, 6) && framed(1, 256, 256) && framed(256, 1, 256)));
  CHECK_FALSE((framed(2, 3, 5) || framed(2, 3, 7) || framed(1, 257, 257) || framed(257, 1, 257)));
  CHECK_FALSE((framed(0, 1, 0) || framed(1, 0, 0)));
}

TEST_CASE("frame protocol: an invalid header is refused before its payload arrives") {
  const auto breaks = [](std::uint32_t size, std::uint8_t reserved) {
    Parser parser;
    Bytes header{'T', 'B', 'F', 'P', 0x02, reserved, 3, 0};
    for (unsigned i = 0; i < 4; ++i) header.push_back(static_cast<std::uint8_t>(size >> (8 * i) & 0xFFU));
    parser.feed(std::span(header).first(11));
    CHECK_FALSE(parser.next());
    CHECK(parser.broken().empty());
    parser.feed(std::span(header).subspan(11));
    CHECK_FALSE(parser.next());
    return !parser.broken().empty();
  };
  constexpr std::uint32_t kMost = 18 + 2 * 256 * 256;
  CHECK_FALSE(breaks(0, 0));
  CHECK_FALSE(breaks(kMost, 0));
  CHECK(breaks(kMost + 1, 0));
  CHECK(breaks(0xFFFFFFFF, 0));
  CHECK(breaks(0, 1));
  CHECK(breaks(0, 0x80));
}

TEST_CASE("frame protocol: each byte of the magic number is checked as soon as it arrives") {
  const Bytes magic{'T', 'B', 'F', 'P'};
  for (std::size_t at = 0; at < magic.size(); ++at) {
    Parser parser;
    for (std::size_t i = 0; i < at; ++i) {
      parser.feed(std::span(magic).subspan(i, 1));
      CHECK_FALSE(parser.next());
      CHECK(parser.broken().empty());
    }
    parser.feed(Bytes{static_cast<std::uint8_t>(magic[at] ^ 0x20U)});
    CHECK_FALSE(parser.next());
    CHECK_FALSE(parser.broken().empty());
  }
}

TEST_CASE("frame protocol: only the eight documented message types are known") {
  const std::vector<int> known{0x01, 0x02, 0x03, 0x04, 0x81, 0x82, 0x84, 0x8F};
  for (int type = 0; type < 256; ++type) {
    CHECK(known_type(static_cast<std::uint8_t>(type)) == (std::find(known.begin(), known.end(), type) != known.end()));
  }
}
