// What identification costs: ELAM in units of one plain J, an array from the store to its parameters, threads, growth,
// and the other models (performance.md A1, A5, A6, B1-B3).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/identify/identify.h"
#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// One taxel's J over its samples as anybody would write it: turning points, curves, residuals. The unit of the goals.
double plain_j(const analysis::ElamModel& model, std::span<const analysis::TaxelBranch> branches);

// 256 synthetic taxels, 660 scored samples each; one thread where not said otherwise. Best of `rounds`. Writes to
// `folder`.
std::vector<Figure> benchmark_identify(int rounds, const std::string& folder);

}  // namespace tactbench::bench
