// Ramps the set-point to a level in small steps (ticks) within the guard's limits; all ramps use this loop.
#pragma once

#include <cstdint>
#include <functional>

#include "bench/rig/rig.h"

namespace tactbench::bench {

struct RampTick {
  bool first = false, last = false;  // both true if one tick reaches the level
  double seconds = 0.0;              // of process time for this tick: 0.1, less for a shorter last one
};

// Called for each tick, before and after its set-point is commanded; each may be empty. An exception ends the ramp.
struct RampHooks {
  std::function<void(const RampTick&)> before, after;
};

// The largest tick (psi, > 0) at `rate_psi_per_s` that the guard accepts.
double ramp_tick_psi(const SafetyLimits& limits, double rate_psi_per_s);

// Ramps from the present `setpoint` to `level`, up or down; each tick updates `setpoint`. Waiting and reading are left
// to the hooks. Returns the raw counts last written. Throws the exceptions of the guard and the drivers; refuses a
// level that is not a number.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, devices::Psi& setpoint, double tick_psi, const RampHooks& hooks);

// Downward in one step; upward at the guard's largest rate: reads feedback and reference before each tick; after each
// tick except the last, waits 0.1 s and calls `each_tick`.
std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick = {});

}  // namespace tactbench::bench
