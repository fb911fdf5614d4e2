// What the run store costs beside a plain file and beside bare SQLite (performance.md D1, D2, D3, D7).
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// Frames of 512 bytes, best of `rounds`, in new files in `folder` each round. The bare table holds the same numbers
// without a hash chain, checks and references.
std::vector<Figure> benchmark_store(int rounds, const std::string& folder);

}  // namespace tactbench::bench
