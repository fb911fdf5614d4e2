// Moves z off the specimen and proves it with the force sensor: the stage's half of the safe state, and the end of each
// press.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/stage/stage.h"

namespace tactbench::bench {

struct RetractOptions {
  double clear_z_mm = 0.0;
  double speed_mm_per_s = 4.0;  // largest speed of the z axis
  double safe_force_n = 0.5;
  int records = 50;
  double low_end_z_mm = 0.0;  // the axis' low end
};

struct RetractProof {
  bool verified = false;          // z is at the clear position or further away, and the force is below the safe force
  bool halted = false;            // every axis reported standstill before z was moved
  std::optional<double> z_mm;     // none: not known
  std::optional<double> force_n;  // |Fz|; none: the sensor could not be read
  std::string text;               // text: "retracted, verified (z 24.000 mm, 0.01 N)"
};

// Halts all axes, arms the stage again and moves z to the clear position. If z is not homed, it is homed instead, which
// moves in the same direction. If z is already further away it stays there, unless a force is measured: then it moves
// to the low end of its axis. Never moves toward the specimen. Without a sensor (null) the result is not verified.
// Waits by calling `wait` in slices of 100 ms, so that it may feed a dead-man; if that throws or returns early, waits
// on the clock itself. The time is bounded by twice the halt, the travel at that speed (or the home timeout) and a few
// replies.
[[nodiscard]] RetractProof retract(devices::Stage& stage, devices::ForceSensor* force, devices::Clock& clock,
                                   const RetractOptions& options,
                                   const std::function<void(devices::Nanoseconds)>& wait) noexcept;

}  // namespace tactbench::bench
