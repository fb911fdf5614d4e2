#include "bench/safety/fail_safe.h"

#include <fmt/format.h>

#include "analysis/pressure_unit.h"
#include "bench/guard/witness.h"

namespace tactbench::bench {

using analysis::PressureUnit;

namespace {

std::string relieved(const BenchConfig& config) {
  return config.regulator.relief.empty() ? "use the relief valve"
                                         : config.regulator.relief + " has to relieve the chamber";
}

// How each witness shows a supply that fails, or a wire that breaks.
std::string dead_supply(const BenchConfig& config, PressureUnit unit) {
  const auto shown = [unit](const char* name, const devices::LinearSpan& span, const TrueRange& range) {
    const double psi = span.pressure(devices::Volts(0.0)).value();
    return fmt::format("{} reads {}, which {}", name, unit.text(psi, 1),
                       range.holds(psi) ? "an empty chamber reads, too" : "cannot be true and is noticed");
  };
  std::string text = "without supply, at 0 V, " +
                     shown("the regulator's monitor", config.regulator.feedback_span, feedback_range(config));
  if (config.reference_independent && !config.reference_gauge)
    text += "; " + shown("the reference", config.reference.span, reference_range(config));
  return text;
}

}  // namespace

std::string when_module_is_lost(const BenchConfig& config, PressureUnit unit) {
  if (config.watchdog_s <= 0.0) {
    return "nothing that tactbench has set brings its output to 0 V, the last set-point may remain; " +
           relieved(config);
  }
  const std::string watchdog = fmt::format("its watchdog ({:g} ms) sets 0 V, which is {}", 1000.0 * config.watchdog_s,
                                           unit.text(zero_volt_psi(config), 1));
  return zero_volt_vents(config) ? watchdog : watchdog + " and no vent; " + relieved(config);
}

std::vector<std::string> fail_safe_layers(const BenchConfig& config, PressureUnit unit) {
  const devices::ModuleProfile& profile = config.module.profile;
  std::vector<std::string> lines = {"tactbench: every run ends vented, with proof of it; trip above " +
                                    unit.short_text(config.limits.trip_psi)};
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
    lines.push_back(fmt::format("WARNING: [dead_man] enabled = false: when the program dies, {}",
                                when_module_is_lost(config, unit)));
  }
  if (profile.dump_coil >= 0) {
    lines.push_back(fmt::format("dump valve on coil {}: opens with every vent and without power", profile.dump_coil));
  }
  for (const std::string& layer : profile.fail_safe.layers) {
    lines.push_back(fmt::format("{}: {}", profile.model, layer));
  }
  if (zero_volt_vents(config)) {
    lines.push_back(fmt::format("without power the module gives 0 V, at which the regulator vents: {}",
                                unit.text(zero_volt_psi(config), 1)));
  } else {
    lines.push_back(fmt::format("WARNING: without power the module gives 0 V, which is {} and does NOT vent; {}",
                                unit.text(zero_volt_psi(config), 1), relieved(config)));
  }
  lines.push_back(dead_supply(config, unit));
  const std::string lost = when_module_is_lost(config, unit);
  if (config.watchdog_s > 0.0) {
    lines.push_back(fmt::format("with a silent bus {}; fed every {:g} ms", lost,
                                static_cast<double>(config.regulator.feed_interval.count()) * 1e-6));
  } else {
    lines.push_back(fmt::format(
        "WARNING: {} has no watchdog that tactbench can set or verify: if the program or the wire dies, {}, "
        "and an emergency stop",
        profile.model, lost));
  }
  return lines;
}

}  // namespace tactbench::bench
