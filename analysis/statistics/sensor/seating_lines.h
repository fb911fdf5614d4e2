// Part of the seating check: whole rows and columns. Used only by seating.cpp.
#pragma once

#include <vector>

#include "analysis/statistics/sensor/seating.h"

namespace tactbench::analysis {

struct SeatingTaxels {
  int rows = 0, columns = 0;
  std::vector<double> response_v, loaded_v, before_v;  // before_v: empty where no last seating may be compared
  std::vector<bool> known_dead;
  std::vector<bool> open_rows, open_columns;  // find_open_lines
};

// Lines that are silent as a whole; the lines across are judged without them.
void find_open_lines(SeatingTaxels& taxels, double least_v);

// Dead lines, half-inserted connectors, edges outside the membrane, along one axis. `lost` is set for the taxels of
// the lines found.
std::vector<SeatingFinding> check_lines(const SeatingTaxels& taxels, bool along_rows, const SeatingOptions& options,
                                        std::vector<bool>& lost);

}  // namespace tactbench::analysis
