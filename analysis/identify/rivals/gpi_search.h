// Local searches for the least J of GPI, many candidates side by side in lanes.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "analysis/identify/elam/evolution.h"
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
  // The best of an evolution about `start` (gpi_search.h).
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

// Vectors, bounds and normal equations of GPI's unknowns, for its local searches.
using GpiVector = Eigen::Matrix<double, kGpiUnknowns, 1>;
using GpiMatrix = Eigen::Matrix<double, kGpiUnknowns, kGpiUnknowns>;

// The unknowns stay where exponentials are harmless.
GpiPoint gpi_within(const GpiVector& to);

inline GpiVector vector_of(const GpiPoint& p) { return Eigen::Map<const GpiVector>(p.data()); }

// The normal equations in one lane: Gauss-Newton's matrix and half of J's gradient.
struct GpiNormal {
  GpiMatrix matrix;
  GpiVector slope;
  GpiNormal() = default;
  GpiNormal(const GpiLanes& lanes, std::size_t lane);
};

// (mu/mu, lambda) evolution strategy with covariance matrix adaptation (Hansen, 2001) for GPI: where an operator of a
// sample begins to move J's slope jumps, and minima lie on such kinks, where no descent along slopes reaches them.
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
