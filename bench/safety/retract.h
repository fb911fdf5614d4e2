// z off the specimen, proved by the force sensor: the stage's half of the safe state, and the end of each press.
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
  double speed_mm_per_s = 4.0;  // what the z axis may go
  double safe_force_n = 0.5;
  int records = 50;
};

struct RetractProof {
  bool verified = false;          // z stands at clear or further off, and the force is below the safe one
  bool halted = false;            // every axis answered that it stands before z was moved
  std::optional<double> z_mm;     // none: not known
  std::optional<double> force_n;  // |Fz|; none: the sensor could not be read
  std::string text;               // for people: "retracted, verified (z 24.000 mm, 0.01 N)"
};

// Halts all axes, arms anew and moves z to clear; a z that is not homed is homed instead, which goes the same way; a z
// further off stays. Never moves toward the specimen. Without a sensor (null) it is not verified. `wait` until a
// process time is asked first, in slices of 100 ms, so that it may feed a dead-man; when it throws or returns early
// the clock itself is waited for. Longest: twice the halt, the way at that speed (or the home timeout) and a few
// replies.
[[nodiscard]] RetractProof retract(devices::Stage& stage, devices::ForceSensor* force, devices::Clock& clock,
                                   const RetractOptions& options,
                                   const std::function<void(devices::Nanoseconds)>& wait) noexcept;

}  // namespace tactbench::bench
