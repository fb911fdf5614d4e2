// A client of the simulated chain that sends and reads raw frames.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "devices/stage/simulated_chain.h"
#include "devices/wire/serial_link.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

struct RawChain {
  explicit RawChain(SimulatedChainOptions options = {}, SimulatedChainFaults faults = {})
      : chain(std::move(options), clock, std::move(faults)) {
    connect();
  }
  void connect() {
    SerialAddress address;
    address.port = chain.address();
    line = open_serial(address);
  }
  void send(const ZaberFrame& frame) const { line->write(encode(frame)); }
  // As many bytes, or those that came before a long silence.
  [[nodiscard]] std::vector<std::uint8_t> read(std::size_t count) const {
    std::vector<std::uint8_t> bytes(count);
    std::size_t filled = 0;
    while (filled < count) {
      const std::size_t got = line->read(std::span(bytes).subspan(filled), kPatient);
      if (got == 0) break;
      filled += got;
    }
    bytes.resize(filled);
    return bytes;
  }
  [[nodiscard]] ZaberBytes next_bytes() const {
    ZaberBytes whole{};
    const std::vector<std::uint8_t> bytes = read(whole.size());
    std::copy(bytes.begin(), bytes.end(), whole.begin());
    return whole;
  }
  [[nodiscard]] ZaberFrame next() const { return decode(next_bytes()); }
  [[nodiscard]] bool says_nothing() const {
    ZaberBytes bytes{};
    return line->read(bytes, kShort) == 0;
  }

  TurnedClock clock;
  SimulatedChain chain;
  std::unique_ptr<ByteStream> line;
};

}  // namespace tactbench::devices
