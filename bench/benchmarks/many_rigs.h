// What a million simulated characterizations would take: extrapolated from a few, which are carried out.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// One characterization: a rig and sensor of its own, the shipped recipe `production`, ELAM for 256 taxels, figures, the
// night's page and store. Four times `rounds` with seeds of their own are carried out in two parts, merged and pruned.
// Figures a characterization are measured; those of a million are these times a million, without what grows faster.
std::vector<Figure> benchmark_many_rigs(int rounds, const std::string& folder);

}  // namespace tactbench::bench
