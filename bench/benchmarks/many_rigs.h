// What a million simulated characterizations would take: extrapolated from a few, which are carried out.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// One characterization: a rig and sensor of its own, the shipped recipe `production`, ELAM for 256 taxels, figures, the
// night's page and store. Four times `rounds` with seeds of their own are carried out in two parts, merged and pruned.
// Figures a characterization are measured; those of a million are these times a million, without what grows faster.
// `program`: the file of the program; empty: that of this process.
std::vector<Figure> benchmark_many_rigs(int rounds, const std::string& folder, const std::string& program = {});

// What was spent on all of the rigs together.
struct ManyRigsSpent {
  int rigs = 0;
  double carried_out_s = 0.0, merged_s = 0.0, pruning_s = 0.0;
  double kept_bytes = 0.0, left_bytes = 0.0, page_bytes = 0.0;  // the store, after its pruning, and the night's page
};
std::vector<Figure> figures_of(const ManyRigsSpent& spent);

}  // namespace tactbench::bench
