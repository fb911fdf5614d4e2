// The minima of J's two halves: of the descending one on a line, of the ascending one by local searches, many
// candidates (u, v, beta_a) side by side in lanes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "analysis/identify/elam/lanes.h"

namespace tactbench::analysis {

using Point = std::array<double, 3>;  // u, v, beta_a

struct Value {
  double j = std::numeric_limits<double>::infinity();
  Point at{0.5, 0.5, 0.5};
};

class AscendingSearch {
 public:
  AscendingSearch(const LaneProblem& problem, std::size_t most) : lanes_(problem, most), at_(lanes_.stride) {}

  void evaluate(std::span<Value> values);
  // Each of `values` downhill: Levenberg-Marquardt in the unit cube; beta_a rests in Gradient::kPlane.
  void descend(std::span<Value> values, int steps, Gradient gradient);
  // (8/16) evolution strategy with covariance matrix adaptation (Hansen, 2001) about `start`, in the metric of its
  // normal equations, in which J would be round except for the kinks: where a sample crosses a knot or the split J's
  // slope jumps, and minima lie on such kinks. Its variates are the same each time.
  Value evolve(const Value& start);

 private:
  struct Lane {
    std::array<double, 6> normal{};
    Point right{};
    double damping = 1e-3;
    bool settled = false;
  };
  void put(std::size_t i, const Point& at);
  void take(std::size_t i, Lane& lane, Gradient gradient) const;
  AscendingLanes lanes_;
  std::vector<Lane> at_;
  std::vector<Point> tried_;
};

// The minimum of J's descending half over alpha_d, beta_d in [0, 1] and of its ascending half over the unit cube in
// (phi(x = 0 long), phi(full length), beta_a); the model's other parameters are left alone. Return J without constant.
double fit_descending(ElamModel& model, std::span<const CurveSamples> curves);
double fit_ascending(ElamModel& model, std::span<const CurveSamples> curves);

}  // namespace tactbench::analysis
