// A refusal or trip of the guard: a fault of Cause::kLimit whatever its id, so that a new interlock gets the right exit
// code without being listed anywhere.
#pragma once

#include <string>
#include <utility>

#include "devices/fault.h"

namespace tactbench::bench {

class Interlock final : public devices::Fault {
 public:
  Interlock(std::string id, std::string device, const std::string& message, std::string remedy)
      : Fault(devices::Cause::kLimit, std::move(id), std::move(device), message, std::move(remedy)) {}
};

}  // namespace tactbench::bench
