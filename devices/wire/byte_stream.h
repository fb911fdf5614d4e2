// A transport of bytes without frames: a serial port (serial_link.h), a pseudo-terminal or a socket (stream_link.h).
// Drivers work with any of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "devices/clock.h"

namespace tactbench::devices {

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  // Sends all bytes. Throws Fault TB-SERIAL-LOST when the device is gone, TB-SERIAL-TIMEOUT when it accepts no bytes.
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  // Waits for bytes in real time and returns as soon as any arrive; 0 if none came before `timeout`. Throws Fault
  // TB-SERIAL-LOST immediately if the device is gone, so that unplugging differs from silence. A lost stream never
  // recovers: create a new one.
  [[nodiscard]] virtual std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) = 0;
  // Discards unread bytes; returns their number.
  virtual std::size_t discard() = 0;
  [[nodiscard]] virtual std::string description() const = 0;
  [[nodiscard]] virtual int descriptor() const = 0;  // for callers that pass it on; the stream owns it
};

}  // namespace tactbench::devices
