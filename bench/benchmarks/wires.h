// Time per exchange over each wire of the simulated rig, against the machine's lower bound.
#pragma once

#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// Medians of `exchanges` each through the shipped drivers; the floor is a bare echo of 12 bytes over TCP between two
// threads in the same process. Ratios are against that floor. Also the time from a hang-up to the fault.
std::vector<Figure> benchmark_wires(int exchanges);

}  // namespace tactbench::bench
