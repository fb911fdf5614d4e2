// The cost J of many candidate parameter sets of one taxel at a time, in vector lanes (vector_lanes.h): most of the
// time of ELAM's identification.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis {

// A pattern curve as a look-up. Inputs are in its own units: grid steps from x0 where the grid is uniform.
class LaneTable {
 public:
  explicit LaneTable(const PatternCurve& curve);
  [[nodiscard]] double unit(double x) const { return uniform_ ? (x - x0_) * per_x_ : x; }
  [[nodiscard]] double value(double u) const;
  struct Place {
    double u, by_y;  // by_y: du/dy
  };
  [[nodiscard]] Place inverse(double y) const;
  [[nodiscard]] std::size_t segment(double u) const;
  [[nodiscard]] bool uniform() const { return uniform_; }
  [[nodiscard]] std::size_t last() const { return knots_.size() - 2; }
  // Per segment: start and rise of the ordinate, and a row more at xu; start and 1 / width of the input.
  [[nodiscard]] const double* rows() const { return rows_.data(); }
  [[nodiscard]] const double* places() const { return places_.data(); }

 private:
  bool uniform_ = true;
  double x0_ = 0.0, per_x_ = 1.0, y0_ = 0.0, per_y_ = 1.0;
  std::vector<double> knots_, y_, next_y_, by_y_, rows_, places_;
  std::vector<std::size_t> first_by_x_, first_by_y_;  // the first segment that reaches into each of so many equal parts
};

// Samples of one target curve that parameters can move: strictly between its ends, ascending in x. In lane units.
struct LaneCurve {
  std::size_t first = 0, end = 0;
  double x_turn = 0.0, y_turn = 0.0;
  double x_pattern = 0.0;            // ascending: where the pattern has y_turn
  double length = 0.0, share = 0.0;  // ascending: xu - x_turn, and as a share of xu - x0
  double rise = 0.0;                 // y_turn - y0, or yu - y_turn
};

struct LaneProblem {
  LaneTable table;
  double x0 = 0.0, xu = 0.0, y0 = 0.0, yu = 0.0;  // in lane units
  double smallest_rise = 0.0;                     // below it a piece of the pattern is saturated [A12]
  double constant = 0.0;                          // J of the samples that no parameter moves
  std::vector<LaneCurve> curves;
  std::vector<double> x, y, weight;
  std::vector<double> pattern;  // descending: the pattern at x, less y0
};
LaneProblem lane_problem(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending);

// For each alpha_d in [0, 1] (not checked) J at the best beta_d in [0, 1], and that beta_d. Sizes a multiple of 8.
void lane_descending(const LaneProblem& problem, std::span<const double> alpha, std::span<double> j,
                     std::span<double> beta);

// Candidates (u, v, beta_a) in the unit cube (not checked), u and v being the relative splits of branches of length 0
// and X.
struct AscendingLanes {
  explicit AscendingLanes(const LaneProblem& problem, std::size_t most);
  void split(std::size_t i);  // after a change of beta[i]
  const LaneProblem* problem;
  std::size_t stride;
  std::vector<double> u, v, beta, j;
  std::vector<bool> is_split;
  std::vector<double> splits, by_beta;  // curves x stride: the split on the pattern, and its derivative
  // Gauss-Newton's normal equations, lower triangle row by row, and right side.
  std::array<std::vector<double>, 6> normal;
  std::array<std::vector<double>, 3> right;
};
enum class Gradient { kNone, kPlane, kSpace };  // none, in (u, v), in all three
void lane_ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient);

}  // namespace tactbench::analysis
