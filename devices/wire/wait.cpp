#include "devices/wire/wait.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>

namespace tactbench::devices {

short wait_for(int descriptor, short events, Nanoseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (auto left = timeout;; left = deadline - std::chrono::steady_clock::now()) {
    left = std::max(left, Nanoseconds(0));
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec span{seconds.count(), (left - seconds).count()};
    pollfd waited{descriptor, events, 0};
    const int ready = ::ppoll(&waited, 1, &span, nullptr);
    if (ready > 0) return waited.revents;
    if (ready == 0) return 0;
    if (errno != EINTR) return POLLERR;
  }
}

}  // namespace tactbench::devices
