// The error type of devices/: a failed exchange with something outside the program. `what()` states what was requested,
// what was received and from whom; `remedy()` what to try. `id()` is stable across releases, e.g. TB-MODBUS-TIMEOUT.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::devices {

// The kind of failure; the exit code depends only on this, not on the id.
enum class Cause {
  kDevice,  // an instrument or its link failed, or is not as expected
  kLimit,   // a limit or an interlock refused a command, or ended the work
};

class Fault : public std::runtime_error {
 public:
  Fault(Cause cause, std::string id, std::string device, const std::string& message, std::string remedy)
      : std::runtime_error(message),
        cause_(cause),
        id_(std::move(id)),
        device_(std::move(device)),
        remedy_(std::move(remedy)) {}
  // With cause kDevice, the most common one.
  Fault(std::string id, std::string device, const std::string& message, std::string remedy)
      : Fault(Cause::kDevice, std::move(id), std::move(device), message, std::move(remedy)) {}
  [[nodiscard]] Cause cause() const { return cause_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& device() const { return device_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  Cause cause_;
  std::string id_;
  std::string device_;
  std::string remedy_;
};

}  // namespace tactbench::devices
