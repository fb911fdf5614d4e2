#include "bench/safety/fail_safe.h"

#include <fmt/format.h>

namespace tactbench::bench {

std::vector<std::string> fail_safe_layers(const BenchConfig& config) {
  const devices::ModuleProfile& profile = config.module.profile;
  std::vector<std::string> lines = {
      fmt::format("tactbench: every run ends vented, with proof of it; trip above {:g} psi", config.limits.trip_psi)};
  if (!config.in_process && config.dead_man.enabled) {
    lines.push_back(fmt::format(
        "dead-man in a process of its own: fires when the program ends, is stopped for {:g} ms or makes no progress "
        "for {:g} ms; vents over its own connection{}{}",
        1000.0 * config.dead_man.timeout_s, 1000.0 * config.dead_man.progress_s,
        config.stage ? fmt::format(", stops the stage and backs z off by {:g} mm", config.dead_man.back_off_mm) : "",
        !config.module.endpoint.serial_port.empty() ? ""  // one line, which the sequencer reads
        : config.dead_man.blind_ends                ? "; if it can no longer reach the module the run ends"
                                                    : "; if it can no longer reach the module the run is warned"));
  } else if (!config.in_process) {
    lines.emplace_back("WARNING: [dead_man] enabled = false: only the module vents when the program dies");
  }
  if (profile.dump_coil >= 0) {
    lines.push_back(fmt::format("dump valve on coil {}: opens with every vent and without power", profile.dump_coil));
  }
  for (const std::string& layer : profile.fail_safe.layers) {
    lines.push_back(fmt::format("{}: {}", profile.model, layer));
  }
  if (config.watchdog_s > 0.0) {
    lines.push_back(fmt::format("watchdog time {:g} ms, fed every {:g} ms", 1000.0 * config.watchdog_s,
                                static_cast<double>(config.regulator.feed_interval.count()) * 1e-6));
  } else {
    lines.push_back(
        fmt::format("WARNING: {} has no watchdog that tactbench can set or verify: if the program or the "
                    "wire dies, the last set-point may remain. Have a relief valve and an emergency stop.",
                    profile.model));
  }
  return lines;
}

}  // namespace tactbench::bench
