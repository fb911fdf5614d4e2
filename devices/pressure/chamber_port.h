// Interface from the simulated analog module to the physics, implemented by bench/simulation. All calls come from the
// simulated module's thread while the clock does not advance.
#pragma once

#include "devices/clock.h"
#include "devices/units.h"

namespace tactbench::devices {

class ChamberPort {
 public:
  virtual ~ChamberPort() = default;
  // From now on the output terminal drives `command` until `hold_until`, then `fallback` (the module's watchdog).
  virtual void drive(Volts command, Nanoseconds hold_until, Volts fallback) = 0;
  // The dump valve, parallel to the regulator and on a digital output: exhausts the chamber regardless of the
  // regulator. Called when its state changes.
  virtual void dump(bool open) = 0;
  [[nodiscard]] virtual Volts feedback() = 0;   // regulator's monitor output now
  [[nodiscard]] virtual Volts reference() = 0;  // reference transducer's output now
};

}  // namespace tactbench::devices
