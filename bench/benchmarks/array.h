// Cost of the simulated array a frame, against plain play operators and against the wire that carries the frame.
#pragma once

#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// 256 taxels, best of `rounds`. A frame on the wire is one scan of the simulated scanner through its driver: median.
std::vector<Figure> benchmark_array(int rounds);

// Seconds for 1000 frames each, and microseconds for one on the wire.
struct ArrayTimes {
  double plain_s = 0.0, specimen_s = 0.0, counts_s = 0.0;
  double wire_us = 0.0;
};
std::vector<Figure> figures_of(const ArrayTimes& times);

}  // namespace tactbench::bench
