// Detects scans that do not follow the load: a scanner that repeats an old frame, or a row with a stuck multiplexer.
// The counts then stay identical, noise included, while the load changes.
#pragma once

#include <vector>

#include "devices/tactile/tactile_array.h"

namespace tactbench::bench {

struct StuckRows {
  bool all = false;       // no row has changed
  std::vector<int> rows;  // rows that have not changed; rows at the converter's limit are not judged
};

class StuckRowWatch {
 public:
  // `load`: any quantity that the array should follow, the same at each call; only changes of at least `least` are
  // considered.
  [[nodiscard]] StuckRows see(const devices::ScanSet& scans, double load, double least);

 private:
  devices::ScanSet last_;
  std::vector<double> changed_at_;  // by row: the load at which it last changed
};

}  // namespace tactbench::bench
