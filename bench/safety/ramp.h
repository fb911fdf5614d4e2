// Ramps the set-point to a level in ticks within the guard's limits; all ramps use this loop.
#pragma once

#include <cstdint>
#include <functional>

#include "bench/rig/rig.h"

namespace tactbench::bench {

struct RampTick {
  bool first = false, last = false;  // both when one tick reaches the level
  double seconds = 0.0;              // of process time for this tick: 0.1, less for a shorter last one
};

// Called for each tick, before and after its set-point is commanded; each may be empty. An exception ends the ramp.
struct RampHooks {
  std::function<void(const RampTick&)> before, after;
};

// The largest tick (psi, above 0) at `rate_psi_per_s`: the guard refuses a larger one.
double ramp_tick_psi(const SafetyLimits& limits, double rate_psi_per_s);

// From `setpoint`, the present one, to `level`, up or down; `setpoint` follows each tick. Neither waits nor reads: the
// hooks do. Returns the raw counts last written. Throws what the guard and the drivers throw; a level that is not a
// number is refused.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, devices::Psi& setpoint, double tick_psi, const RampHooks& hooks);

// Downward at once; upward at the guard's largest rate: reads both witnesses before each tick; waits 0.1 s and calls
// `each_tick` after each but the last.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick = {});

}  // namespace tactbench::bench
