#include "bench/run/watch/stuck_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tactbench::bench {

StuckRows StuckRowWatch::see(const devices::ScanSet& scans, double load, double least) {
  const auto rows = static_cast<std::size_t>(scans.rows);
  const auto columns = static_cast<std::size_t>(scans.columns);
  StuckRows stuck;
  if (scans.counts.size() != last_.counts.size() || changed_at_.size() != rows) {
    last_ = scans;
    changed_at_.assign(rows, load);
    return stuck;
  }
  std::size_t judged = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    bool same = true, inside = false;
    for (std::size_t i = row * columns; i < scans.counts.size(); i += rows * columns) {
      for (std::size_t k = i; k < i + columns; ++k) {
        same = same && scans.counts[k] == last_.counts[k];
        inside = inside || (scans.counts[k] != 0 && scans.counts[k] != UINT16_MAX);
      }
    }
    judged += inside ? 1U : 0U;
    if (!same) changed_at_[row] = load;
    if (inside && std::abs(load - changed_at_[row]) >= least) stuck.rows.push_back(static_cast<int>(row));
  }
  stuck.all = judged > 0 && stuck.rows.size() == judged;
  last_ = scans;
  return stuck;
}

}  // namespace tactbench::bench
