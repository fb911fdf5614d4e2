// Cost of the run store against a plain file and against bare SQLite.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

struct StoreSizes {
  std::size_t frames = 3310, durable = 1000;  // durable: those that wait for the disk, one by one
};
// Frames of 512 bytes, in new files in `folder` each round; each stretch of 100 written frames, and each whole reading,
// counts with the best of `rounds`. The bare table holds the same numbers
// without a hash chain, checks and references.
std::vector<Figure> benchmark_store(int rounds, const std::string& folder, const StoreSizes& sizes = {});

// Seconds for all durable frames (plain, full) or for all others.
struct StoreTimes {
  double plain = 0.0, full = 0.0;
  double bare = 0.0, normal = 0.0, grouped = 0.0;  // written
  double bare_read = 0.0, read = 0.0;
};
std::vector<Figure> figures_of(const StoreTimes& times, const StoreSizes& sizes = {});

}  // namespace tactbench::bench
