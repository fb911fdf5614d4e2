// Finds scans that do not follow the load: a scanner that repeats an old frame, a row whose multiplexer is stuck. Its
// counts stay the same to the last bit, noise included, while the load changes.
#pragma once

#include <vector>

#include "devices/tactile/tactile_array.h"

namespace tactbench::bench {

struct StuckRows {
  bool all = false;       // no row has changed
  std::vector<int> rows;  // that have not; those that stand at the converter's limit have nothing to tell
};

class StuckRowWatch {
 public:
  // `load` is any number that the array should follow; one of the same kind each time, compared by `least`.
  [[nodiscard]] StuckRows see(const devices::ScanSet& scans, double load, double least);

 private:
  devices::ScanSet last_;
  std::vector<double> changed_at_;  // by row: the load at which it last changed
};

}  // namespace tactbench::bench
