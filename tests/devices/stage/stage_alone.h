// The Zaber driver and simulated devices without a wire, under a turned clock; single answers may be replaced.
#pragma once

#include <map>

#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/stage/zaber_rig.h"

namespace tactbench::devices {

// x moves at most at 4800 x 9.375 = 45000 steps/s, which are 4.46484375 mm/s, with 4 x 11250 = 45000 steps/s^2.
inline ZaberStageOptions even_stage() {
  ZaberStageOptions options = paper_stage();
  options.axes[0].maximum_speed = MillimetresPerSecond(4.46484375);
  return options;
}

inline std::vector<ChainDeviceOptions> even_chain() {
  std::vector<ChainDeviceOptions> devices = paper_chain();
  devices[0].acceleration = 4;
  devices[0].home_speed = devices[0].target_speed = 4800;
  return devices;
}

struct StageAlone {
  // The command and the data of an answer; none: silence.
  using Answer = std::optional<std::pair<ZaberCommand, std::int32_t>>;

  explicit StageAlone(ZaberStageOptions options = even_stage(),
                      const std::vector<ChainDeviceOptions>& devices = even_chain())
      : chain(&clock, devices), stage([this] { return chain.open(); }, std::move(options), clock) {
    chain.script = [this](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
      if (frame.device == 1 && frame.command == ZaberCommand::kStatus) polls.push_back(clock.now());
      const auto found = instead.find({frame.device, frame.command});
      if (found == instead.end()) return std::nullopt;
      std::deque<Answer>& answers = found->second;
      const Answer one = answers.front();
      if (answers.size() > 1) answers.pop_front();
      if (!one) return ScriptedChain::Frames{};
      return ScriptedChain::Frames{{frame.device, one->first, one->second, frame.id}};
    };
  }
  // x then moves up to 90000 steps, which are 8.9296875 mm.
  void ready() {
    (void)take(1, ZaberCommand::kMaximumPosition, 90000);
    stage.arm();
    for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) stage.home(axis);
    (void)sent();
  }
  // Hands an instruction to a device past the driver.
  ScriptedChain::Frames take(std::uint8_t device, ZaberCommand command, std::int32_t data) {
    ScriptedChain::Frames replies;
    chain.devices[device - 1U].receive({device, command, data, 0}, clock.now(), device, replies);
    return replies;
  }
  // The frames sent since the last call, without their ids.
  ScriptedChain::Frames sent() {
    ScriptedChain::Frames frames = chain.take_sent();
    for (ZaberFrame& one : frames) one.id = 0;
    return frames;
  }
  [[nodiscard]] double steps_of_x() const { return chain.devices[0].position(clock.now()).value() / (0.00635 / 64); }

  TurnedClock clock;
  ScriptedChain chain;
  ZaberStage stage;
  // What a device answers to a command instead of itself: each answer once, the last one always.
  std::map<std::pair<std::uint8_t, ZaberCommand>, std::deque<Answer>> instead;
  std::vector<Nanoseconds> polls;  // when x was asked for its status
};

}  // namespace tactbench::devices
