// Devices of a chain at the other end of an in-memory line: a written byte is received at once, a read returns the
// answer one piece at a time, or nothing at once. A test may answer in place of a device.
#pragma once

#include <catch2/catch.hpp>

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
#include "devices/stage/simulated_chain.h"
#include "devices/stage/zaber_stage.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

// A Zaber driver, or a client that speaks in frames, and a simulated chain at the two ends of one wire, under a clock.

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

// One simulated device of the chain without a wire, addressed as a client would.

// Sends each instruction with message id 5.
struct ChainBench {
  explicit ChainBench(const ChainDeviceOptions& options = {}) : device(options) {}

  std::vector<ZaberFrame> send(ZaberCommand command, std::int32_t data, std::uint8_t to = 1) {
    std::vector<ZaberFrame> replies;
    device.run(now, replies);
    replies.clear();
    if (device.hears(to)) device.receive({to, command, data, 5}, now, 1, replies);
    return replies;
  }
  // 0: it refused nothing.
  std::int32_t error_of(ZaberCommand command, std::int32_t data) {
    const auto replies = send(command, data);
    return replies.size() == 1 && replies[0].command == ZaberCommand::kError ? replies[0].data : 0;
  }
  std::vector<ZaberFrame> pass(Nanoseconds time) {
    now += time;
    std::vector<ZaberFrame> replies;
    device.run(now, replies);
    return replies;
  }
  // The data of the single answer.
  std::int32_t read(ZaberCommand command, std::int32_t data = 0) {
    const auto replies = send(command, data);
    REQUIRE(replies.size() == 1);
    return replies[0].data;
  }
  std::int32_t setting(ZaberCommand which) {
    return read(ZaberCommand::kReturnSetting, static_cast<std::int32_t>(which));
  }
  [[nodiscard]] double millimetres() const { return device.position(now).value(); }
  void home() {
    REQUIRE(send(ZaberCommand::kHome, 0).empty());
    REQUIRE(pass(std::chrono::seconds(60)) == std::vector<ZaberFrame>{{1, ZaberCommand::kHome, 0, 5}});
  }
  // An instruction that is answered once its motion has ended, at this place.
  void moves(ZaberCommand command, std::int32_t data, std::int32_t place) {
    INFO(name(command) << " " << data);
    CHECK(send(command, data).empty());
    CHECK(pass(std::chrono::seconds(300)) == std::vector<ZaberFrame>{{1, command, place, 5}});
  }
  void ends_after(Nanoseconds time, const ZaberFrame& reply) {
    CHECK(pass(time - Nanoseconds(1)).empty());
    CHECK(pass(Nanoseconds(1)) == std::vector<ZaberFrame>{reply});
  }
  void go_to(std::int32_t target) {
    REQUIRE(send(ZaberCommand::kMoveAbsolute, target).empty());
    REQUIRE(pass(std::chrono::hours(1)).size() == 1);
  }

  ChainDevice device;
  Nanoseconds now{0};
};

}  // namespace tactbench::devices
