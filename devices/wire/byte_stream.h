// A transport of bytes without frames: a serial port, a pseudo-terminal or a socket. Drivers work with any of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/wire/options.h"

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

// ByteStream over a serial port (libserialport), without its pitfalls: unplugging is an immediate fault instead of
// silence, waiting does not load a core, and only one program can hold a port.
struct SerialPortInfo {
  std::string name;
  std::string description;
  int usb_vendor = -1;  // -1: not a USB port
  int usb_product = -1;
  std::string usb_serial;
};

// Ports of the system, without pseudo-terminals; a port may have nothing attached.
[[nodiscard]] std::vector<SerialPortInfo> list_serial_ports();

// Opens the port with eight data bits and no handshake; discards unread bytes. Addresses for open_stream() are passed
// to it, because libserialport opens only ports. Throws Fault TB-SERIAL-OPEN, and TB-SERIAL-BUSY when another program
// holds the port. Each write() takes at most one second.
[[nodiscard]] std::unique_ptr<ByteStream> open_serial(const SerialAddress& address);

// ByteStream over addresses that libserialport cannot open: a pseudo-terminal, a TCP connection or a local stream
// socket.

// True for the addresses that open_stream() accepts: "/dev/pts/N", "tcp:HOST:PORT" (IPv6 as "tcp:[::1]:PORT"),
// "unix:PATH".
[[nodiscard]] bool is_stream_address(const std::string& address);

// Opens `address`; a connection not made within `timeout` is a fault (resolving a host's name takes further time).
// Unread bytes are discarded. Throws Fault TB-SERIAL-OPEN, and TB-SERIAL-BUSY when another ByteStream
// holds the pseudo-terminal; without `lock` the lock is neither checked nor held. Each write() takes at most `timeout`.
[[nodiscard]] std::unique_ptr<ByteStream> open_stream(const std::string& address,
                                                      Nanoseconds timeout = std::chrono::seconds(2), bool lock = true);

// A stream over a non-blocking descriptor that was opened and configured elsewhere (a serial port, a pseudo-terminal, a
// socket); the destructor closes it. `address` names it in faults.
[[nodiscard]] std::unique_ptr<ByteStream> adopt_stream(int descriptor, const std::string& address,
                                                       Nanoseconds timeout = std::chrono::seconds(2));

}  // namespace tactbench::devices
