// What stands between a dead program and a pressed specimen: the fail-safe layers of a bench, in words for preflight.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"

namespace tactbench::bench {

// One line a layer, from the fastest to the last. Never empty: says so when the module has none.
std::vector<std::string> fail_safe_layers(const BenchConfig& config);

}  // namespace tactbench::bench
