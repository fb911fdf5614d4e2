// Local searches for the least J of GPI, many candidates side by side in lanes.
#pragma once

#include <span>
#include <vector>

#include "analysis/identify/rivals/gpi_lanes.h"

namespace tactbench::analysis {

GpiParameters gpi_parameters(const GpiPoint& unknowns, double x_span, double y_span);

// The first `most` of `sorted` whose J (`j_of`) is more than a share `apart` above that of the one before: nearer ones
// are held for the same minimum.
template <class One>
void keep_apart(std::vector<One>& sorted, std::size_t most, double apart, const auto& j_of) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < sorted.size() && kept < most; ++i) {
    if (kept > 0 && !(j_of(sorted[i]) > j_of(sorted[kept - 1]) * (1.0 + apart))) continue;
    if (kept < i) sorted[kept] = std::move(sorted[i]);
    ++kept;
  }
  sorted.erase(sorted.begin() + static_cast<std::ptrdiff_t>(kept), sorted.end());
}

class GpiSearch {
 public:
  // Both are kept as pointers.
  GpiSearch(const GpiTree& tree, const GpiTree::Target& target) : lanes_(tree), target_(&target) {}

  // Sets j of each.
  void rate(std::span<GpiFound> found);
  // Each of `found` downhill by at most `steps` steps of Levenberg-Marquardt; sets j.
  void descend(std::span<GpiFound> found, int steps);
  // The best of an evolution about `start` (gpi_evolution.h).
  GpiFound evolve(const GpiFound& start, double size, int generations);
  // Evolutions about all `starts` in rounds, each as long as all before: after each the best are gone on with, `most`
  // after the first and half as many after each further one, of those whose J differ by more than a share `apart`.
  // The ends, best first.
  std::vector<GpiFound> tournament(std::span<const GpiFound> starts, double size, std::size_t most, int generations,
                                   double apart);
  // Standard errors at `found` from Gauss-Newton's Hessian, `variance` being that of a sample.
  GpiPoint errors(const GpiFound& found, double variance);

 private:
  // Evaluates point(i) for each i of `chosen` in lanes, and calls visit(i, lane) while the lane holds it.
  void each(std::span<const std::size_t> chosen, bool gradient, const auto& point, const auto& visit);

  GpiLanes lanes_;
  const GpiTree::Target* target_;
};

}  // namespace tactbench::analysis
