// Devices of a chain at the other end of an in-memory line: a written byte is received at once, a read returns the
// answer one piece at a time, or nothing at once. A test may answer in place of a device.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/stage/chain_device.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/stage/zaber_rig.h"

namespace tactbench::devices {

class ScriptedChain {
 public:
  using Frames = std::vector<ZaberFrame>;
  // The answer to a frame with message ids; none: the devices answer.
  using Script = std::function<std::optional<Frames>(const ZaberFrame&)>;

  // Without a clock the devices are at time 0.
  explicit ScriptedChain(const Clock* clock = nullptr, const std::vector<ChainDeviceOptions>& options = paper_chain())
      : devices(options.begin(), options.end()), clock_(clock) {}

  std::unique_ptr<ByteStream> open() {
    ++opened;
    if (refused_openings > 0) {
      --refused_openings;
      throw Fault("TB-SERIAL-OPEN", "line", "the line cannot be opened", "Mend it.");
    }
    return std::make_unique<End>(*this);
  }
  // A reply that is read next; as a device in message-id mode, or one without when its id is 0, sends it.
  void say(const ZaberFrame& frame) {
    ZaberBytes bytes = encode_without_id(frame);
    if (frame.id != 0) bytes[5] = frame.id;
    say_bytes({bytes.begin(), bytes.end()});
  }
  void say_bytes(std::vector<std::uint8_t> bytes) { pieces.push_back(std::move(bytes)); }
  // The frames sent since the last call.
  Frames take_sent() { return std::exchange(sent, {}); }
  [[nodiscard]] std::size_t count(ZaberCommand command) const {
    return static_cast<std::size_t>(
        std::count_if(sent.begin(), sent.end(), [&](const ZaberFrame& one) { return one.command == command; }));
  }
  [[nodiscard]] Nanoseconds now() const { return clock_ != nullptr ? clock_->now() : Nanoseconds(0); }

  std::vector<ChainDevice> devices;
  Script script;
  Frames sent;
  std::deque<std::vector<std::uint8_t>> pieces;
  int opened = 0, refused_openings = 0, reads = 0, discards = 0;
  bool lost = false;
  Nanoseconds longest_wait{0};
  Nanoseconds held_up{0};  // the next read takes this long

 private:
  class End final : public ByteStream {
   public:
    explicit End(ScriptedChain& chain) : chain_(chain) {}
    void write(std::span<const std::uint8_t> bytes) override { chain_.hear(bytes); }
    std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
      ++chain_.reads;
      chain_.longest_wait = std::max(chain_.longest_wait, timeout);
      if (chain_.lost) throw Fault("TB-SERIAL-LOST", "line", "the line is gone", "Mend it.");
      std::this_thread::sleep_for(std::exchange(chain_.held_up, Nanoseconds(0)));
      if (chain_.pieces.empty()) return 0;
      const std::vector<std::uint8_t> piece = std::move(chain_.pieces.front());
      chain_.pieces.pop_front();
      std::copy(piece.begin(), piece.end(), into.begin());
      return piece.size();
    }
    std::size_t discard() override {
      ++chain_.discards;
      return std::exchange(chain_.pieces, {}).size();
    }
    [[nodiscard]] std::string description() const override { return "line"; }
    [[nodiscard]] int descriptor() const override { return -1; }

   private:
    ScriptedChain& chain_;
  };

  void hear(std::span<const std::uint8_t> bytes) {
    if (lost) throw Fault("TB-SERIAL-LOST", "line", "the line is gone", "Mend it.");
    ZaberBytes whole{};
    std::copy_n(bytes.begin(), std::min(bytes.size(), whole.size()), whole.begin());
    sent.push_back(decode(whole));
    if (script) {
      if (const auto replies = script(sent.back())) {
        for (const ZaberFrame& one : *replies) say(one);
        return;
      }
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
      ChainDevice& device = devices[i];
      Frames replies;
      device.run(now(), replies);
      if (device.hears(whole[0])) {
        const ZaberFrame frame = device.message_ids() ? decode(whole) : decode_without_id(whole);
        device.receive(frame, now(), static_cast<std::uint8_t>(i + 1), replies);
      }
      for (ZaberFrame& one : replies) {
        if (!device.message_ids()) one.id = 0;
        say(one);
      }
    }
  }

  const Clock* clock_;
};

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

  ManualClock clock;
  ScriptedChain chain;
  ZaberStage stage;
  // Scripted answers to a command instead of the device's own: each answer once, the last one always.
  std::map<std::pair<std::uint8_t, ZaberCommand>, std::deque<Answer>> instead;
  std::vector<Nanoseconds> polls;  // when x was asked for its status
};

// Armed and homed; what that took has been forgotten.
struct ReadyStage : StageAlone {
  explicit ReadyStage(ZaberStageOptions options = even_stage(),
                      const std::vector<ChainDeviceOptions>& devices = even_chain())
      : StageAlone(std::move(options), devices) {
    ready();
  }
};

}  // namespace tactbench::devices
