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

// Seconds for 1000 frames (plain, full) or 3310.
struct StoreTimes {
  double plain = 0.0, full = 0.0;
  double bare = 0.0, normal = 0.0, grouped = 0.0;  // written
  double bare_read = 0.0, read = 0.0;
};
std::vector<Figure> figures_of(const StoreTimes& times);

}  // namespace tactbench::bench
