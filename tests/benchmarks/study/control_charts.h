// False alarms and power of the control charts of figures over 60 runs, on randomly drawn figures.
#pragma once

#include <vector>

#include "tests/benchmarks/study/study_value.h"

namespace tactbench::bench {

// One figure, `draws` histories a case (standard error at most 0.5 % / sqrt(draws / 10000)): false alarms, and steps
// and ramps found, with the median run. Nights of 671 figures, draws / 100 periods a case: nights and periods of 60
// nights with a false report, figures that shifted and are found, the share of false ones among those reported.
// Baselines of 8, 20 and 30 runs. The truth comes from random numbers alone; seeds are the case's number.
std::vector<Figure> benchmark_charts(int draws);

}  // namespace tactbench::bench
