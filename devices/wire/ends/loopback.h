// A bound socket on 127.0.0.1 for a simulated end.
#pragma once

#include <string>

namespace tactbench::devices {

struct BoundSocket {
  int socket = -1;  // non-blocking; the caller closes it
  int port = 0;
};

// `type` is SOCK_STREAM (listening) or SOCK_DGRAM; port 0 lets the system choose. Throws Fault TB-SIM-LISTEN.
[[nodiscard]] BoundSocket bind_loopback(int type, int port, const std::string& device);

}  // namespace tactbench::devices
