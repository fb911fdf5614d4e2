// The fail-safe layers of a bench that act when the program dies, in words for preflight.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"

namespace tactbench::bench {

// One line per layer, fastest first. Never empty: a module without any gets a line that says so.
std::vector<std::string> fail_safe_layers(const BenchConfig& config);

// What becomes of the set-point when nothing reaches the module any more: "its watchdog (1000 ms) sets 0 V, ...".
std::string when_module_is_lost(const BenchConfig& config);

}  // namespace tactbench::bench
