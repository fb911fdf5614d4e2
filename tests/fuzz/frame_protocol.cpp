// Fuzzer of the frame-source protocol. First byte: 0 takes the rest as one packet (type, tag, payload), so that the CRC
// does not stand in the way of the payload decoders; any other takes it as a stream, cut in pieces of that size.
#include "devices/tactile/frame_protocol.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

using namespace tactbench::devices::frame_protocol;

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

// What decodes encodes to the same packet.
void check(const Packet& packet) {
  const auto message = decode(packet);
  if (!message) return;
  require(known_type(packet.type));
  Parser parser;
  parser.feed(encode(*message));
  const auto again = parser.next();
  require(again && again->type == packet.type && again->tag == packet.tag && again->payload == packet.payload);
  require(!parser.next() && parser.broken().empty());
}

struct Parsed {
  std::vector<Packet> packets;
  std::string broken;
};

Parsed parse(std::span<const std::uint8_t> bytes, std::size_t piece) {
  Parser parser;
  Parsed parsed;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    parser.feed(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    while (auto packet = parser.next()) parsed.packets.push_back(std::move(*packet));
  }
  parsed.broken = parser.broken();
  return parsed;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  if (data[0] == 0) {
    if (rest.size() < 3) return 0;
    check({rest[0], static_cast<std::uint16_t>(rest[1] | rest[2] << 8), {rest.begin() + 3, rest.end()}});
    return 0;
  }
  const Parsed whole = parse(rest, std::max<std::size_t>(rest.size(), 1));
  const Parsed pieces = parse(rest, data[0]);
  require(whole.broken == pieces.broken && whole.packets.size() == pieces.packets.size());
  for (std::size_t i = 0; i < whole.packets.size(); ++i) {
    require(whole.packets[i].payload == pieces.packets[i].payload && whole.packets[i].payload.size() <= kMaxPayload);
    check(whole.packets[i]);
  }
  return 0;
}
