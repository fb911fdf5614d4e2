#include "analysis/statistics/uncertainty/measuring_interval.h"

#include <cmath>

namespace tactbench::analysis {

MeasuringInterval measuring_interval(const ConditionUncertainty& condition, bool up, double mpe_psi,
                                     std::span<const std::size_t> fitted, double share) {
  MeasuringInterval longest, now;
  for (std::size_t level = 0; level < condition.pressure_psi.size(); ++level) {
    if (condition.up[level] != up) continue;
    std::size_t within = 0;
    for (const std::size_t taxel : fitted) {
      const std::size_t at = level * condition.taxels() + taxel;
      within += std::abs(condition.error_psi[at]) + condition.expanded_psi[at] <= mpe_psi ? 1 : 0;
    }
    if (within == 0 || static_cast<double>(within) < share * static_cast<double>(fitted.size()) - 1e-9) {
      now = {};
      continue;
    }
    if (!now.any) now = {true, condition.pressure_psi[level], condition.pressure_psi[level]};
    now.high_psi = condition.pressure_psi[level];
    if (!longest.any || now.high_psi - now.low_psi > longest.high_psi - longest.low_psi) longest = now;
  }
  return longest;
}

}  // namespace tactbench::analysis
