// The error type of devices/: a failed exchange with something outside the program. `what()` states what was requested,
// what was received and from whom; `remedy()` what to try. `id()` is stable across releases, e.g. TB-MODBUS-TIMEOUT.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::devices {

class Fault : public std::runtime_error {
 public:
  // `remedy` empty: who shows the fault to a person knows one for the id (bench/common/error_table.h).
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
