// The fail-safe layers of a bench that act when the program dies, in words for preflight.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"

namespace tactbench::bench {

// One line per layer, fastest first. Never empty: a module without any gets a line that says so.
std::vector<std::string> fail_safe_layers(const BenchConfig& config);

}  // namespace tactbench::bench
