// Fetches one small page from a device's built-in web server with HTTP/1.0. No library: Beast would bring its headers
// into devices/ for one fixed request, and every step here needs a deadline, as everywhere in devices/.
#pragma once

#include <string>

#include "devices/clock.h"

namespace tactbench::devices {

struct HttpPage {
  std::string host;  // numeric address
  int port = 80;
  std::string path;  // begins with '/'
  Nanoseconds timeout = std::chrono::seconds(3);
  std::size_t largest = std::size_t{1} << 18U;  // bytes, including headers
};

// The body of the answer "200". Returns or throws within `timeout`. Throws Fault TB-HTTP-OPEN (no address, refused, no
// connection in time), TB-HTTP-TIMEOUT, TB-HTTP-ANSWER (other status, too large, cut short, not HTTP).
[[nodiscard]] std::string http_get(const HttpPage& page, const std::string& device, Clock& clock);

}  // namespace tactbench::devices
