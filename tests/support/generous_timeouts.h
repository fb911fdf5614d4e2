// Times that a program must not exceed in real time, wide enough for a machine on which a thread waits half a second
// for its turn: for rigs in another process than the program. What is asserted of them stays. The order of the shipped
// ones stays too: the dead-man before the module's watchdog. The simulated stage's line is a pseudo-terminal, whose
// bytes are moved by a thread of the kernel: beside busy loops and six such rigs at once it came up to 6 s late.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "sequences/recipe.h"

namespace tactbench::tests {

// How many times as long as the shipped ones. TACTBENCH_SHIPPED_TIMES=1 in the environment: 1, to measure the figures
// of the shipped bench on a quiet machine.
inline double roominess() {
  const char* shipped = std::getenv("TACTBENCH_SHIPPED_TIMES");
  return shipped != nullptr && *shipped != '\0' ? 1.0 : 5.0;
}

// Of a bench whose process time runs `rate` times as fast as real time, as the bench file takes them.
inline std::vector<sequences::Override> roomy_times(double rate, bool serial_regulator = false) {
  const double room = roominess();
  const auto process = [&](double shipped, double most) {
    return fmt::format("{:.0f}", std::min(most, shipped * room * rate));
  };
  const auto real = [&](double shipped) { return fmt::format("{:.0f}", shipped * room); };
  std::vector<sequences::Override> all = {
      {"limits.vent_timeout_s", process(20.0, 120.0)},
      {"settling.timeout_s", process(20.0, 600.0)},
      {"limits.stale_s", real(1.0)},  // which the bench stretches by the rate itself
      {"dead_man.timeout_ms", real(400.0)},
      {"dead_man.progress_ms", real(1500.0)},
      {"scanner.frame_timeout_ms", real(500.0)},
      {"stage.reply_timeout_ms", fmt::format("{:.0f}", room > 1.0 ? 10000.0 : 300.0)},
      {"force.reply_timeout_ms", real(500.0)}};
  if (serial_regulator) {
    all.push_back({"regulator.reply_timeout_ms", real(250.0)});
  } else {
    all.push_back({"module.watchdog_ms", process(1000.0, 60000.0)});
    all.push_back({"module.response_timeout_ms", real(500.0)});
  }
  return all;
}

}  // namespace tactbench::tests
