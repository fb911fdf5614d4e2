#include "bench/safety/fail_safe.h"

#include <fmt/format.h>

#include "analysis/pressure_unit.h"
#include "bench/pressure/pressure_kinds.h"

namespace tactbench::bench {

using analysis::PressureUnit;

std::string when_source_is_lost(const BenchConfig& config, PressureUnit unit) {
  return pressure_kind(config).when_lost(config, unit);
}

std::vector<std::string> fail_safe_layers(const BenchConfig& config, PressureUnit unit) {
  std::vector<std::string> lines = {"tactbench: every run ends vented, with proof of it; trip above " +
                                    unit.short_text(config.limits.trip_psi)};
  if (!config.in_process && config.dead_man.enabled) {
    lines.push_back(fmt::format(
        "dead-man in a separate process: fires when the program ends, is stopped for {:g} ms or makes no progress "
        "for {:g} ms; vents over {}{}{}",
        1000.0 * config.dead_man.timeout_s, 1000.0 * config.dead_man.progress_s,
        on_serial_line(config) ? "the same serial line, which it then opens" : "its own connection",
        config.stage ? fmt::format(", stops the stage and backs z off by {:g} mm", config.dead_man.back_off_mm) : "",
        on_serial_line(config)       ? ""  // one line, which the sequencer reads
        : config.dead_man.blind_ends ? "; if it can no longer reach the module the run ends"
                                     : "; if it can no longer reach the module the run is warned"));
  } else if (!config.in_process) {
    lines.push_back(fmt::format("WARNING: [dead_man] enabled = false: when the program dies, {}",
                                when_source_is_lost(config, unit)));
  }
  const std::vector<std::string> own = pressure_kind(config).layers(config, unit);
  lines.insert(lines.end(), own.begin(), own.end());
  return lines;
}

}  // namespace tactbench::bench
