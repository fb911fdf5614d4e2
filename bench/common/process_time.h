// Converts seconds of a configuration or a recipe to process time.
#pragma once

#include <cmath>
#include <cstdint>

#include "devices/clock.h"

namespace tactbench::bench {

inline devices::Nanoseconds seconds(double value) {
  return devices::Nanoseconds(static_cast<std::int64_t>(std::llround(value * 1e9)));
}

}  // namespace tactbench::bench
