// Identity of a device: role, model, serial number, firmware; stored with each run.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::devices {

enum class Origin { kSimulated, kHardware };

struct Identity {
  std::string role;  // "regulator", "pressure reference", "tactile scanner", ...
  std::string model;
  std::string serial;
  std::string firmware;
  Origin origin = Origin::kHardware;
};

// Rules for every actuator (pressure source or stage): it sends nothing until armed, refuses an out-of-range command
// before sending it, keeps no command across a broken link, and can be made safe (PressureSource::vent, Stage::halt)
// from any state. tests/devices/actuator_contract_wire.cpp tests each driver against these rules.
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

// The error type of devices/: a failed exchange with something outside the program. `what()` states what was requested,
// what was received and from whom; `remedy()` what to try. `id()` is stable across releases, e.g. TB-MODBUS-TIMEOUT.
class Fault : public std::runtime_error {
 public:
  // `remedy` empty: the caller uses the remedy for the id in bench/common/error_table.h.
  Fault(std::string id, std::string device, const std::string& message, std::string remedy = {})
      : std::runtime_error(message), id_(std::move(id)), device_(std::move(device)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& device() const { return device_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string id_;
  std::string device_;
  std::string remedy_;
};

}  // namespace tactbench::devices
