// Describes, for the preflight, the fail-safe layers of a bench that act when the program dies.
#pragma once

#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/config/config.h"

namespace tactbench::bench {

// One line per layer, fastest first. Never empty: a source without any layer gets a line that says so.
std::vector<std::string> fail_safe_layers(const BenchConfig& config,
                                          analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// What happens to the set-point when the pressure source is no longer reachable: "its watchdog (1000 ms) sets 0 V,
// ...".
std::string when_source_is_lost(const BenchConfig& config, analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

}  // namespace tactbench::bench
