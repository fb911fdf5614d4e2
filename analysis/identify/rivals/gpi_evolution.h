// (mu/mu, lambda) evolution strategy with covariance matrix adaptation (Hansen, 2001) for GPI: where an operator of a
// sample begins to move J's slope jumps, and minima lie on such kinks, where no descent along slopes reaches them.
#pragma once

#include <Eigen/Cholesky>

#include "analysis/identify/elam/evolution.h"
#include "analysis/identify/rivals/gpi_normal.h"

namespace tactbench::analysis {

class GpiEvolution {
 public:
  // About `start`, in the metric of its normal equations; first steps are `size` times the root of its J. Variates are
  // the same each time. `lanes` is only used here and in each go, and may be another one of the same tree.
  GpiEvolution(GpiLanes& lanes, const GpiTree::Target& target, const GpiFound& start, double size);
  // On to generation `last`, or until the steps are too small to matter.
  void go(GpiLanes& lanes, const GpiTree::Target& target, int last);
  [[nodiscard]] const GpiFound& best() const { return best_; }

 private:
  void generation(GpiLanes& lanes, const GpiTree::Target& target);

  GpiFound start_, best_;
  Eigen::LLT<GpiMatrix> metric_;
  Variates variate_;
  GpiVector mean_ = GpiVector::Zero(), path_ = GpiVector::Zero(), way_ = GpiVector::Zero();
  GpiMatrix covariance_ = GpiMatrix::Identity();
  double size_, smallest_, fading_ = 1.0;
  int generation_ = 0;
};

}  // namespace tactbench::analysis
