// The figures of a run that are followed from run to run: by the nightly suite, by trend, by control charts.
#pragma once

#include <map>
#include <string>

#include "analysis/statistics/figures/evaluation.h"

namespace tactbench::analysis {

// By name, with the unit in it. `evaluation` is what was judged; parameters are means over the fitted taxels. A figure
// that is not finite is left out.
std::map<std::string, double> figures_of(const ArrayFit& fit, const Evaluation& evaluation);

}  // namespace tactbench::analysis
