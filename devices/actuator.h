// Rules for every actuator (pressure source or stage): it sends nothing until armed, refuses an out-of-range command
// before sending it, keeps no command across a broken link, and can be made safe (PressureSource::vent, Stage::halt)
// from any state. tests/devices/actuator_laws_wire.cpp tests each driver against these rules.
#pragma once

namespace tactbench::devices {

class Actuator {
 public:
  virtual ~Actuator() = default;
  // Reads the device's state and makes it ready without driving anything; commands are sent from then on. Before arm(),
  // every command throws Fault TB-<DEVICE>-NOT-ARMED. A command that is out of its limits or not-a-number throws Fault
  // TB-<DEVICE>-LIMIT. In both cases nothing is sent. arm() throws Fault.
  virtual void arm() = 0;
  // Stops commands until arm(). A failed exchange also disarms, because the device's state is then not known.
  virtual void disarm() noexcept = 0;
  [[nodiscard]] virtual bool armed() const = 0;
};

}  // namespace tactbench::devices
