// What every actuator obeys, pressure source and stage alike: silent until armed, refuses what is out of range before
// sending, remembers no command across a broken link, and can be made safe (PressureSource::vent, Stage::halt) from any
// state. tests/devices/actuator_laws_wire.cpp holds each driver to it.
#pragma once

namespace tactbench::devices {

class Actuator {
 public:
  virtual ~Actuator() = default;
  // Learns the device's state and makes it ready, driving nothing; from now on commands are sent. Before, each command
  // throws Fault TB-<DEVICE>-NOT-ARMED and sends nothing. A command beyond its limits, or with what is no number,
  // throws Fault TB-<DEVICE>-LIMIT and sends nothing. Throws Fault.
  virtual void arm() = 0;
  // No further command is sent until arm(). A failed exchange disarms too: what the device does now is not known.
  virtual void disarm() noexcept = 0;
  [[nodiscard]] virtual bool armed() const = 0;
};

}  // namespace tactbench::devices
