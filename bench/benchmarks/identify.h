// Cost of identification: ELAM in units of one plain J, an array from the store to its parameters, threads, growth, and
// the other models.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/identify/elam/identify.h"
#include "analysis/identify/sensor_model.h"
#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// One taxel's J over its samples, written plainly: turning points, curves, residuals. The unit of the goals.
double plain_j(const analysis::ElamModel& model, std::span<const analysis::TaxelBranch> branches);

// 256 synthetic taxels, 660 scored samples each; one thread where not said otherwise. Best of `rounds`. Writes to
// `folder`.
std::vector<Figure> benchmark_identify(int rounds, const std::string& folder);

}  // namespace tactbench::bench
