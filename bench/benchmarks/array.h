// What the simulated array costs a frame, beside plain play operators and beside the wire that carries the frame
// (performance.md G1).
#pragma once

#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// 256 taxels, best of `rounds`. A frame on the wire is one scan of the simulated scanner through its driver: median.
std::vector<Figure> benchmark_array(int rounds);

}  // namespace tactbench::bench
