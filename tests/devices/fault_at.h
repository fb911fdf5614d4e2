// Injects a fault into one request to a simulated instrument, which counts its requests from 0.
#pragma once

#include <atomic>
#include <memory>

#include "devices/fault_injection.h"

namespace tactbench::devices {

inline FaultInjector fault_at(int number, InjectedFault fault) {
  return [asked = std::make_shared<std::atomic<int>>(0), number, fault] {
    return (*asked)++ == number ? fault : InjectedFault::kNone;
  };
}

}  // namespace tactbench::devices
