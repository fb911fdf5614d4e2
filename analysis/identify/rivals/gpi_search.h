// Local searches for the least J of GPI, many candidates side by side in lanes.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "analysis/identify/rivals/gpi_lanes.h"

namespace tactbench::analysis {

GpiParameters gpi_parameters(const GpiPoint& unknowns, double x_span, double y_span);

struct GpiFound {
  GpiPoint at{};
  double j = std::numeric_limits<double>::infinity();  // of outputs in 0..1
};

class GpiSearch {
 public:
  // Both are kept as pointers.
  GpiSearch(const GpiTree& tree, const GpiTree::Target& target) : lanes_(tree), target_(&target) {}

  // Each of `found` downhill by at most `steps` steps of Levenberg-Marquardt; sets j.
  void descend(std::span<GpiFound> found, int steps);
  // (mu/mu, lambda) evolution strategy with covariance matrix adaptation (Hansen, 2001) about `start`, in the metric of
  // its normal equations: where an operator of a sample begins to move J's slope jumps, and minima lie on such kinks.
  // Its variates are the same each time.
  GpiFound evolve(const GpiFound& start, double size, int generations);
  // Standard errors at `found` from Gauss-Newton's Hessian, `variance` being that of a sample.
  GpiPoint errors(const GpiFound& found, double variance);

 private:
  GpiLanes lanes_;
  const GpiTree::Target* target_;
};

}  // namespace tactbench::analysis
