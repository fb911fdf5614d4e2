// What the page costs: its own process with 8 viewers at 20 Hz, and the run beside it.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// `rounds`: pairs of runs, without the page and with it. Makes its stores in `folder`.
std::vector<Figure> benchmark_page(int rounds, const std::string& folder);

}  // namespace tactbench::bench
