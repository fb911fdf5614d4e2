// What verbs take on stores of thousands of runs. By `tactbench benchmark large-store`: minutes, gigabytes of disk.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// A store for each number of runs: small runs, each with frames, figures, a fit and verdicts, and last two real
// characterizations of the simulated rig. Each verb runs in a process of its own; the best of the rounds counts, by
// wall clock. Throws std::runtime_error when a verb fails.
// `program`: the file of the program; empty: that of this process.
std::vector<Figure> benchmark_large_store(const std::vector<int>& runs, int rounds, const std::string& folder,
                                          const std::string& program = {});

// Such a store at `path`: as many runs, the last two of them runs 1 and 2 of the store `real`.
void make_large_store(const std::string& path, int runs, const std::string& real);

}  // namespace tactbench::bench
