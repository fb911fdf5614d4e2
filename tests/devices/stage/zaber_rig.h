// A Zaber driver and its simulated chain at the two ends of one wire, under a turned clock.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "devices/stage/simulated_chain.h"
#include "devices/stage/zaber_stage.h"
#include "devices/wire/serial_link.h"
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

template <class Time = TurnedClock>
struct ZaberRig {
  explicit ZaberRig(SimulatedChainOptions chain_options = {}, SimulatedChainFaults faults = {},
                    ZaberStageOptions options = paper_stage())
      : chain(std::move(chain_options), clock, faults),
        stage([this] { return connect(); }, std::move(options), clock) {}

  std::unique_ptr<ByteStream> connect() const {
    SerialAddress address;
    address.port = chain.address();
    return open_serial(address);
  }

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

inline const std::vector<ZaberCommand> kMoving{ZaberCommand::kHome, ZaberCommand::kMoveAbsolute,
                                               ZaberCommand::kMoveRelative, ZaberCommand::kConstantSpeed,
                                               ZaberCommand::kMoveToStoredPosition};

}  // namespace tactbench::devices
