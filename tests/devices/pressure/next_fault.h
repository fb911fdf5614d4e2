// The fault that a simulated module injects next, set by a test while the module runs.
#pragma once

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "devices/pressure/simulated_module.h"

namespace tactbench::devices {

class NextFault {
 public:
  explicit NextFault(SimulatedModuleFaults& faults) {
    faults.inject = [this] {
      const InjectedFault fault = next_;
      ++met_;
      return fault;
    };
  }
  NextFault& operator=(InjectedFault fault) {
    next_ = fault;
    return *this;
  }
  // Sends a request that is not answered, and waits until it has met its fault: on a busy machine the next fault may
  // be set before.
  template <class Send>
  void meets(Send send) const {
    const long before = met_;
    send();
    for (int i = 0; i < 20'000 && met_ == before; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    REQUIRE(met_ == before + 1);
  }

 private:
  std::atomic<InjectedFault> next_{InjectedFault::kNone};
  std::atomic<long> met_{0};
};

}  // namespace tactbench::devices
