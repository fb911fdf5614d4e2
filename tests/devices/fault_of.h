// What fault an action ends in.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "devices/fault.h"

namespace tactbench::devices {

// The fault's id, "none" when there was none. Each fault has to say what happened and what to try.
template <class Action>
std::string fault_of(Action action) {
  try {
    action();
  } catch (const Fault& fault) {
    CHECK_FALSE(std::string(fault.what()).empty());
    CHECK_FALSE(fault.device().empty());
    CHECK_FALSE(fault.remedy().empty());
    return fault.id();
  }
  return "none";
}

}  // namespace tactbench::devices
