// Brings the set-point to a level as the guard lets it.
#pragma once

#include <functional>

#include "bench/rig.h"

namespace tactbench::bench {

// Downward at once; upward in ticks of 0.1 s at the guard's largest rate, both witnesses read at each, `each_tick`
// called after each. Returns the raw counts last written. Throws what the guard, the drivers and `each_tick` throw.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick = {});

}  // namespace tactbench::bench
