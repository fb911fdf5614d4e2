// Cost of the run store against a plain file and against bare SQLite.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// Frames of 512 bytes, in new files in `folder` each round; each stretch of 100 written frames, and each whole reading,
// counts with the best of `rounds`. The bare table holds the same numbers
// without a hash chain, checks and references.
std::vector<Figure> benchmark_store(int rounds, const std::string& folder);

}  // namespace tactbench::bench
