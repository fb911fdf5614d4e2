// Cost of the dynamic frame compensator beside ELAM's on arrays of the same size and pressures of the same course.
#pragma once

#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

std::vector<Figure> benchmark_compensate_dynamic(int rounds);

}  // namespace tactbench::bench
