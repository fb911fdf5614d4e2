// Brings the set-point to a level in ticks, as the guard lets it: the one loop that does so.
#pragma once

#include <cstdint>
#include <functional>

#include "bench/rig/rig.h"

namespace tactbench::bench {

struct RampTick {
  bool first = false, last = false;  // both where the level is reached at once
  double seconds = 0.0;  // of process time, that the set-point may stand at it: 0.1, less for a shorter last one
};

// Called for each tick, before its set-point is commanded and after; each may be empty. What they throw ends the ramp.
struct RampHooks {
  std::function<void(const RampTick&)> before, after;
};

// The largest tick (psi, above 0) at `rate_psi_per_s`: the guard refuses a larger one.
double ramp_tick_psi(const SafetyLimits& limits, double rate_psi_per_s);

// From `setpoint`, where the set-point stands, to `level`, up or down; `setpoint` follows each tick. Waits for nothing
// by itself and reads nothing: that is for the hooks. Returns the raw counts last written. Throws what the guard and
// the drivers throw; a level that is not a number is refused.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, devices::Psi& setpoint, double tick_psi, const RampHooks& hooks);

// Downward at once; upward at the guard's largest rate, both witnesses read before each tick, 0.1 s waited and
// `each_tick` called after each but the last.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick = {});

}  // namespace tactbench::bench
