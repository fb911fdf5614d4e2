#include "bench/safety/fail_safe.h"

#include <fmt/format.h>

namespace tactbench::bench {

std::vector<std::string> fail_safe_layers(const BenchConfig& config) {
  const devices::ModuleProfile& profile = config.module.profile;
  std::vector<std::string> lines = {fmt::format(
      "tactbench: every way out of a run vents and proves it; trip above {:g} psi", config.limits.trip_psi)};
  for (const std::string& layer : profile.fail_safe.layers) {
    lines.push_back(fmt::format("{}: {}", profile.model, layer));
  }
  if (config.watchdog_s > 0.0) {
    lines.push_back(fmt::format("watchdog time {:g} ms, fed every {:g} ms", 1000.0 * config.watchdog_s,
                                static_cast<double>(config.regulator.feed_interval.count()) * 1e-6));
  } else {
    lines.push_back(
        fmt::format("WARNING: {} has no watchdog that tactbench can set or verify: if the program or the "
                    "wire dies, the last set-point may stand. Have a relief valve and an emergency stop.",
                    profile.model));
  }
  return lines;
}

}  // namespace tactbench::bench
