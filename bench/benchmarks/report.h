// Cost of the calibration report against writing its bytes.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

struct ReportSizes {
  int side = 16, repeats = 5;  // taxels a side
};
// A run of both sequences, evaluated with its own fit. Best of `rounds`. Writes to `folder`.
std::vector<Figure> benchmark_report(int rounds, const std::string& folder, const ReportSizes& sizes = {});

struct ReportTimes {
  double bytes = 0.0, write_s = 0.0, rendered_s = 0.0;
};
std::vector<Figure> figures_of(const ReportTimes& times);

}  // namespace tactbench::bench
