// A Zaber driver, or a client that speaks in frames, and a simulated chain at the two ends of one wire, under a clock.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "devices/stage/simulated_chain.h"
#include "devices/stage/zaber_stage.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

inline ZaberStageOptions paper_stage() {
  ZaberStageOptions options;
  options.axes[1].device = 2;
  options.axes[2].device = 3;
  options.axes[2].device_id = 5082;
  options.axes[2].high = Millimetres(50.0);
  options.axes[2].maximum_speed = MillimetresPerSecond(8.0);
  options.reply_timeout = std::chrono::seconds(5);  // never reached where the chain answers
  options.origin = Origin::kSimulated;
  return options;
}

// Where a test waits for silence.
inline ZaberStageOptions impatient_stage() {
  ZaberStageOptions options = paper_stage();
  options.reply_timeout = kShort;
  return options;
}

inline std::unique_ptr<ByteStream> connect_to(const SimulatedChain& chain) {
  SerialAddress address;
  address.port = chain.address();
  return open_serial(address);
}

template <class Time = ManualClock>
struct ZaberRig {
  explicit ZaberRig(SimulatedChainOptions chain_options = {}, SimulatedChainFaults faults = {},
                    ZaberStageOptions options = paper_stage())
      : chain(std::move(chain_options), clock, faults),
        stage([this] { return connect(); }, std::move(options), clock) {}

  std::unique_ptr<ByteStream> connect() const { return connect_to(chain); }

  // Instructions of that kind that reached the chain, from request number `from` on.
  std::size_t count(const std::vector<ZaberCommand>& kinds, std::size_t from = 0) const {
    const auto requests = chain.requests();
    return static_cast<std::size_t>(std::count_if(
        requests.begin() + static_cast<std::ptrdiff_t>(from), requests.end(),
        [&](const ZaberFrame& one) { return std::find(kinds.begin(), kinds.end(), one.command) != kinds.end(); }));
  }

  void arm_and_home() {
    stage.arm();
    for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) stage.home(axis);
  }

  Time clock;
  SimulatedChain chain;
  ZaberStage stage;
};

// A client of the simulated chain that sends and reads raw frames.
struct RawChain {
  explicit RawChain(SimulatedChainOptions options = {}, SimulatedChainFaults faults = {})
      : chain(std::move(options), clock, std::move(faults)) {
    connect();
  }
  void connect() { line = connect_to(chain); }
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
  // The next frame that comes answers this one.
  void expect(const ZaberFrame& frame, const ZaberFrame& answer) const {
    INFO(name(frame.command) << " to " << int{frame.device});
    send(frame);
    CHECK(next() == answer);
  }
  [[nodiscard]] bool says_nothing() const {
    ZaberBytes bytes{};
    return line->read(bytes, kShort) == 0;
  }

  ManualClock clock;
  SimulatedChain chain;
  std::unique_ptr<ByteStream> line;
};

inline const std::vector<ZaberCommand> kMoving{ZaberCommand::kHome, ZaberCommand::kMoveAbsolute,
                                               ZaberCommand::kMoveRelative, ZaberCommand::kConstantSpeed,
                                               ZaberCommand::kMoveToStoredPosition};

}  // namespace tactbench::devices
