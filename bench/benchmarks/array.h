// Cost of the simulated array a frame, against plain play operators and against the wire that carries the frame.
#pragma once

#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// 256 taxels, best of `rounds`. A frame on the wire is one scan of the simulated scanner through its driver: median.
std::vector<Figure> benchmark_array(int rounds);

}  // namespace tactbench::bench
