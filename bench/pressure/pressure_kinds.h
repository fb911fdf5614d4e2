// The registry of pressure sources: one row per value of [regulator] kind. To add a kind: write a driver, its codec and
// its simulated end in devices/pressure, its keys in a row of bench/config/config_pressure.cpp, and a row here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/config/instrument_kinds.h"
#include "devices/pressure/pressure_source.h"

namespace tactbench::devices {
class AnalogModule;
}  // namespace tactbench::devices

namespace tactbench::bench {

struct PressureKind {
  // `output` and `input` are the modules of the bench; null: none. Does not communicate yet. Throws Fault.
  std::unique_ptr<devices::PressureSource> (*make)(const BenchConfig& config, devices::AnalogModule* output,
                                                   devices::AnalogModule* input, devices::Clock& clock);
  Serve serve;                                       // null: the modules are its simulated end
  double (*highest_psi)(const BenchConfig& config);  // that it can be set to
  double (*step_psi)(const BenchConfig& config);     // between two neighbouring set-points
  // Protection layers that make the chamber safe without the program, and those that do not, one line per layer,
  // fastest first.
  std::vector<std::string> (*layers)(const BenchConfig& config, analysis::PressureUnit unit);
  // What happens to the set-point when communication is lost: "its watchdog (1000 ms) sets 0 V, ...".
  std::string (*when_lost)(const BenchConfig& config, analysis::PressureUnit unit);
};

std::span<const PressureKind> pressure_kinds();  // in the order of RegulatorKind
inline const PressureKind& pressure_kind(const BenchConfig& config) {
  return row_of(pressure_kinds(), config.regulator_kind);
}

}  // namespace tactbench::bench
