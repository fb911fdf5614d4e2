#include "devices/wire/wait.h"

#include <poll.h>

#include <cerrno>

#include "devices/wire/ends/end_activity.h"

namespace tactbench::devices {
namespace {

constexpr Nanoseconds kTurn = std::chrono::milliseconds(1);       // between two polls of the ends
constexpr Nanoseconds kLongestHeldUp = std::chrono::seconds(20);  // an end that never finishes is a defect

}  // namespace

Nanoseconds left_until(RealTime end) {
  const Nanoseconds left = end - std::chrono::steady_clock::now();
  if (left > Nanoseconds(0)) return left;
  return left > -kLongestHeldUp && EndActivity::any() ? kTurn : Nanoseconds(0);
}

short wait_for(int descriptor, short events, Nanoseconds timeout) {
  const RealTime deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    // First checks for ends at work, then for bytes: in this order, since an end answers before it stops working.
    const Nanoseconds left = timeout > Nanoseconds(0) ? left_until(deadline) : Nanoseconds(0);
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec span{seconds.count(), (left - seconds).count()};
    pollfd waited{descriptor, events, 0};
    const int ready = ::ppoll(&waited, 1, &span, nullptr);
    if (ready > 0) return waited.revents;
    if (ready < 0 && errno != EINTR) return POLLERR;
    if (ready == 0 && left == Nanoseconds(0)) return 0;
  }
}

}  // namespace tactbench::devices
