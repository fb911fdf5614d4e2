// The laws of every actuator, pressure source and stage: silent until armed, refuses what is out of range before
// sending, remembers no command across a broken link, and can be made safe (PressureSource::vent, Stage::halt) from any
// state. tests/devices/actuator_laws_wire.cpp holds each driver to it.
#pragma once

namespace tactbench::devices {

class Actuator {
 public:
  virtual ~Actuator() = default;
  // Reads the device's state and makes it ready, driving nothing; from now on commands are sent. Before, each command
  // throws Fault TB-<DEVICE>-NOT-ARMED and sends nothing. A command beyond its limits, or with not-a-number,
  // throws Fault TB-<DEVICE>-LIMIT, of Cause::kLimit, and sends nothing. Throws Fault.
  virtual void arm() = 0;
  // No further command is sent until arm(). A failed exchange disarms too: the device's state is then not known.
  virtual void disarm() noexcept = 0;
  [[nodiscard]] virtual bool armed() const = 0;
};

}  // namespace tactbench::devices
