#include "analysis/statistics/control/false_discovery.h"

#include <algorithm>
#include <cstddef>

namespace tactbench::analysis {

std::vector<bool> discoveries(std::span<const double> probabilities, double rate) {
  std::vector<double> sorted(probabilities.begin(), probabilities.end());
  std::ranges::sort(sorted);
  double limit = -1.0;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (sorted[k] <= rate * static_cast<double>(k + 1) / static_cast<double>(sorted.size())) limit = sorted[k];
  std::vector<bool> reported;
  for (const double probability : probabilities) reported.push_back(probability <= limit);
  return reported;
}

}  // namespace tactbench::analysis
