// Returns the fault that an action throws.
#pragma once

#include <catch2/catch.hpp>

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "devices/device.h"
#include "devices/fault_injection.h"

namespace tactbench::devices {

// Runs `act`; the fault it throws, empty when it throws none.
template <class Act>
std::optional<Fault> fault_of(Act&& act) {
  try {
    act();
  } catch (const Fault& fault) {
    return fault;
  }
  return std::nullopt;
}

// The same; each fault has to state the event and its device. (Its remedy may be the one of the table of errors.)
template <class Act>
std::optional<Fault> whole_fault_of(Act&& act) {
  const auto fault = fault_of(act);
  if (!fault) return fault;
  CHECK_FALSE(std::string(fault->what()).empty());
  CHECK_FALSE(fault->device().empty());
  return fault;
}

// The fault's id, "none" when there was none.
template <class Act>
std::string fault_id_of(Act&& act) {
  const auto fault = whole_fault_of(act);
  return fault ? fault->id() : "none";
}

// A fault with this id, of this device, with this number or word in its event.
template <class Act>
void check_fault(Act&& act, const std::string& id, const std::string& device = {}, const std::string& fact = {}) {
  const auto fault = whole_fault_of(act);
  REQUIRE(fault);
  CHECK(fault->id() == id);
  CHECK_THAT(fault->device(), Catch::Contains(device));
  CHECK_THAT(fault->what(), Catch::Contains(fact));
}

// Injects a fault into one request to a simulated instrument, which counts its requests from 0.

inline FaultInjector fault_at(int number, InjectedFault fault) {
  return [asked = std::make_shared<std::atomic<int>>(0), number, fault] {
    return (*asked)++ == number ? fault : InjectedFault::kNone;
  };
}

}  // namespace tactbench::devices
