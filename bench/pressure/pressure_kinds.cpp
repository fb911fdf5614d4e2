#include "bench/pressure/pressure_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bench/guard/witness.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/serial_controller.h"
#include "devices/pressure/simulated_controller.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::bench {

using analysis::PressureUnit;

namespace {

using LayerLines = std::vector<std::string>;

std::string relieved(const BenchConfig& config) {
  return config.regulator.relief.empty() ? "use the relief valve"
                                         : config.regulator.relief + " must relieve the chamber";
}

std::string shown_at_0_v(const char* name, const devices::LinearSpan& span, const TrueRange& range, PressureUnit unit) {
  const double psi = span.pressure(devices::Volts(0.0)).value();
  return fmt::format("{} reads {}, which {}", name, unit.text(psi, 1),
                     range.holds(psi) ? "looks like an empty chamber" : "cannot be true and is noticed");
}

// How the transducer on a module shows a supply that fails, or a wire that breaks; empty: there is none.
std::string dead_transducer(const BenchConfig& config, PressureUnit unit) {
  if (!config.reference_independent || config.reference_gauge) return {};
  return shown_at_0_v("the reference", config.reference.span, reference_range(config), unit);
}

// --- a regulator behind an analog module

std::unique_ptr<devices::PressureSource> make_module(const BenchConfig& config, devices::AnalogModule* output,
                                                     devices::AnalogModule* input, devices::Clock& clock) {
  return std::make_unique<devices::Regulator>(*output, *input, config.regulator, clock);
}

double module_highest_psi(const BenchConfig& config) {
  const devices::LinearSpan& span = config.regulator.command_span;
  return std::min(span.high, span.pressure(devices::Volts(config.module.profile.outputs.volts.high))).value();
}

double module_step_psi(const BenchConfig& config) {
  const devices::LinearScale volts = config.module.profile.outputs.volts, psi = config.regulator.command_span.scale();
  return std::abs((volts.high - volts.low) / (volts.raw_high - volts.raw_low) * (psi.high - psi.low) /
                  (psi.raw_high - psi.raw_low));
}

std::string when_module_is_lost(const BenchConfig& config, PressureUnit unit) {
  if (config.watchdog_s <= 0.0) {
    return "nothing that tactbench has set brings its output to 0 V, the last set-point may remain; " +
           relieved(config);
  }
  const std::string watchdog = fmt::format("its watchdog ({:g} ms) sets 0 V, which is {}", 1000.0 * config.watchdog_s,
                                           unit.text(zero_volt_psi(config), 1));
  return zero_volt_vents(config) ? watchdog : watchdog + " and does not vent; " + relieved(config);
}

LayerLines module_layers(const BenchConfig& config, PressureUnit unit) {
  const devices::ModuleProfile& profile = config.module.profile;
  LayerLines lines;
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
  const std::string reference = dead_transducer(config, unit);
  lines.push_back(
      "without supply, at 0 V, " +
      shown_at_0_v("the regulator's monitor", config.regulator.feedback_span, feedback_range(config), unit) +
      (reference.empty() ? "" : "; " + reference));
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

// --- a pressure controller on a serial line

std::unique_ptr<devices::PressureSource> make_serial(const BenchConfig& config, devices::AnalogModule* /*output*/,
                                                     devices::AnalogModule* /*input*/, devices::Clock& clock) {
  return std::make_unique<devices::SerialController>(
      [address = config.controller_address] { return devices::open_serial(address); }, config.regulator,
      config.controller, clock);
}

SimulatedEnd serve_serial(BenchConfig& config, const SimulatedWorld& world) {
  auto end = std::make_shared<devices::SimulatedController>(config.controller, config.regulator.command_span.high,
                                                            world.chamber, world.inject);
  const std::string port = config.controller_address.port = end->path();
  return {std::move(end),
          {{fmt::format("pressure controller, ASCII lines, unit {}", config.controller.unit), port}},
          {{"regulator.port", port}}};
}

double serial_highest_psi(const BenchConfig& config) { return config.regulator.command_span.high.value(); }
double serial_step_psi(const BenchConfig& config) { return std::pow(10.0, -config.controller.decimals); }

std::string when_serial_is_lost(const BenchConfig& config, PressureUnit /*unit*/) {
  return "it has no watchdog and keeps its last set-point; " + relieved(config);
}

LayerLines serial_layers(const BenchConfig& config, PressureUnit unit) {
  LayerLines lines;
  if (config.controller.exhausts) lines.emplace_back("exhaust valve of the controller: opened by every vent");
  const std::string reference = dead_transducer(config, unit);
  lines.push_back("without supply the controller does not answer, which is noticed" +
                  (reference.empty() ? "" : "; at 0 V " + reference));
  lines.push_back(fmt::format("WARNING: {} without power shuts its valves and may keep the pressure; {}",
                              config.regulator.model, relieved(config)));
  lines.push_back(
      fmt::format("WARNING: {} has no watchdog: if its line breaks, or all programs die, it keeps its last set-point; "
                  "{}, and an emergency stop; the dead-man can reach it only over this line",
                  config.regulator.model, relieved(config)));
  return lines;
}

constexpr std::array kPressureKinds{
    PressureKind{make_module, nullptr, module_highest_psi, module_step_psi, module_layers, when_module_is_lost},
    PressureKind{make_serial, serve_serial, serial_highest_psi, serial_step_psi, serial_layers, when_serial_is_lost}};

}  // namespace

std::span<const PressureKind> pressure_kinds() { return kPressureKinds; }

}  // namespace tactbench::bench
