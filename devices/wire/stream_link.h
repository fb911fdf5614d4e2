// ByteStream over addresses that libserialport cannot open: a pseudo-terminal, a TCP connection or a local stream
// socket.
#pragma once

#include <memory>
#include <string>

#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

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
