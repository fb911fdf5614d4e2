#pragma once
// Time-outs of tests that talk to a process or socket of this machine.
#include <chrono>

#include "devices/clock.h"

namespace tactbench::devices {

constexpr Nanoseconds kPatient = std::chrono::seconds(20);      // never runs out while the other end answers
constexpr Nanoseconds kShort = std::chrono::milliseconds(400);  // for what does not answer, and long for what does

}  // namespace tactbench::devices
