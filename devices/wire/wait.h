// Waiting for a descriptor in real time, bounded, interrupted calls retried.
#pragma once

#include "devices/clock.h"

namespace tactbench::devices {

// Blocks until poll() reports one of `events`, a hang-up or an error, at most `timeout`. Returns poll's revents; 0 at
// the timeout.
[[nodiscard]] short wait_for(int descriptor, short events, Nanoseconds timeout);

}  // namespace tactbench::devices
