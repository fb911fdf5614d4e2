// Line of a daisy chain: sends instructions and matches replies by device number and message id. All other frames go to
// a listener. Waits in real time; does not know about axes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "devices/stage/zaber_binary.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

class ZaberLine {
 public:
  using Listener = std::function<void(const ZaberFrame&)>;
  // `silence`: half a reply is dropped after this time. Longer than the devices' own 10 ms, because a USB adapter
  // delays bytes (FTDI: 16 ms).
  ZaberLine(std::unique_ptr<ByteStream> stream, Nanoseconds reply_timeout, Nanoseconds silence, Listener others);
  // Lets the devices drop half a frame left on the line, and discards unread bytes. Blocks 12 ms.
  void settle();
  // Sends with a message id that is not used again before release(). The reply, for instance a move's end, goes to the
  // listener.
  std::uint8_t send(std::uint8_t device, ZaberCommand command, std::int32_t data);
  void release(std::uint8_t id) { held_[id] = false; }
  // Sends and waits for the reply, which may be an error; none if nothing came within the reply timeout.
  [[nodiscard]] std::optional<ZaberFrame> ask(std::uint8_t device, ZaberCommand command, std::int32_t data);
  // The same without message id, for devices whose mode is not known: the reply is recognised by its command. The data
  // must not be negative.
  [[nodiscard]] std::optional<ZaberFrame> ask_without_id(std::uint8_t device, ZaberCommand command, std::int32_t data);
  void send_without_id(std::uint8_t device, ZaberCommand command, std::int32_t data);
  // Numbers all devices from the computer's end and waits until `devices` have answered, at most `timeout`.
  void renumber(int devices, Nanoseconds timeout);

 private:
  std::uint8_t new_id();
  void write(const ZaberFrame& frame);
  std::optional<ZaberFrame> await(const std::function<bool(const ZaberFrame&)>& wanted, Nanoseconds timeout);

  std::unique_ptr<ByteStream> stream_;
  Nanoseconds reply_timeout_;
  Listener others_;
  ZaberParser parser_;
  std::uint8_t last_id_ = 0;
  std::array<bool, 256> held_{};
};

}  // namespace tactbench::devices
