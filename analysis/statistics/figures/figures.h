// The figures of a run that the nightly suite, trends and control charts track from run to run.
#pragma once

#include <map>
#include <string>

#include "analysis/statistics/figures/evaluation.h"

namespace tactbench::analysis {

// By name, with the unit in it. `evaluation` is what was judged; parameters are means over the fitted taxels. A figure
// that is not finite is left out.
std::map<std::string, double> figures_of(const SensorModel& fit, const Evaluation& evaluation);

}  // namespace tactbench::analysis
