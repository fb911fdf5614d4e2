// Bounded waiting for a descriptor in real time; interrupted calls are retried. A timeout is extended while a simulated
// end of this process still owes an answer (end_activity.h).
#pragma once

#include <chrono>

#include "devices/clock.h"

namespace tactbench::devices {

using RealTime = std::chrono::steady_clock::time_point;

// Real time until `end`; 0: it has passed, and no simulated end owes an answer.
[[nodiscard]] Nanoseconds left_until(RealTime end);

// Blocks until poll() reports one of `events`, a hang-up or an error, at most `timeout`; 0 only polls once. Returns
// poll's revents; 0 at the timeout.
[[nodiscard]] short wait_for(int descriptor, short events, Nanoseconds timeout);

}  // namespace tactbench::devices
