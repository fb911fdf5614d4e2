// Shared by the programs that run inside the virtual machine: values to print, conditions to wait for, a fault's parts.
// Time is real here, on an emulated processor.
#pragma once

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "devices/device.h"

namespace tactbench::tests {

using SteadyTime = std::chrono::steady_clock::time_point;

inline SteadyTime now() { return std::chrono::steady_clock::now(); }
inline double milliseconds(std::chrono::nanoseconds span) {
  return std::chrono::duration<double, std::milli>(span).count();
}
inline void figure(const char* name, double value, const char* unit) {
  fmt::print("FIGURE {} {:.3f} {}\n", name, value, unit);
  std::fflush(stdout);
}

// Asks until `condition` holds; false after ten seconds. For what the kernel does by and by, as enumeration.
template <class Condition>
bool within_ten_seconds(Condition condition) {
  for (const auto end = now() + std::chrono::seconds(10); now() < end;) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

// Runs `act`, which has to throw; each fault has to say of whom and what to try.
template <class Act>
devices::Fault fault_of(Act act) {
  std::optional<devices::Fault> thrown;
  try {
    act();
  } catch (const devices::Fault& fault) {
    thrown = fault;
  }
  REQUIRE(thrown);
  CHECK_FALSE(thrown->device().empty());
  CHECK_FALSE(thrown->remedy().empty());
  return *thrown;
}

}  // namespace tactbench::tests
