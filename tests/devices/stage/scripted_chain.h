// Devices of a chain at the other end of a line that is no wire: a byte written is heard at once, a read returns what
// was answered, one piece a time, or at once nothing. A test may answer in a device's place.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/fault.h"
#include "devices/stage/chain_device.h"
#include "devices/stage/simulated_chain.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

class ScriptedChain {
 public:
  using Frames = std::vector<ZaberFrame>;
  // What is answered to a frame as sent with message ids; none: the devices answer.
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

}  // namespace tactbench::devices
