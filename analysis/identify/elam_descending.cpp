// alpha_d, beta_d: the target curve is affine in beta_d, so for each alpha_d the best beta_d is known in closed form
// and one variable with several minima is left: a grid, then the best brackets divided until nothing moves.
#include <algorithm>
#include <array>
#include <limits>

#include "analysis/identify/elam_samples.h"
#include "analysis/identify/knots.h"

namespace tactbench::analysis {
namespace {

constexpr int kGrid = 256;     // intervals of alpha_d
constexpr int kBrackets = 4;   // local minima of the grid that are looked into
constexpr int kDivisions = 8;  // of a bracket, each round
constexpr int kFirstRounds = 3;
constexpr int kLastRounds = 10;  // each narrows the bracket 4 times: 2^-8 x 4^-13 is below 1e-10

struct Value {
  double j = std::numeric_limits<double>::infinity();
  double alpha = 0.0, beta = 0.0;
};

class DescendingError {
 public:
  DescendingError(const ElamModel& model, std::span<const CurveSamples> curves)
      : curves_(curves),
        pattern_(model.descending),
        x0_(model.x0()),
        xu_(model.xu()),
        y0_(model.y0()),
        yu_(model.yu()),
        tiny_(kSaturatedShare * (model.yu() - model.y0())) {
    for (const CurveSamples& curve : curves)
      for (const double x : curve.x) rise_.push_back(model.descending(x) - y0_);
    slope_.resize(rise_.size());
    offset_.resize(rise_.size());
  }

  // Best over beta_d in [0, 1] for this alpha_d. J is summed from residuals, not expanded: no cancellation.
  [[nodiscard]] Value operator()(double alpha) {
    double gg = 0.0, gr = 0.0;
    std::size_t k = 0;
    for (const CurveSamples& curve : curves_) {
      const double depth = std::max(curve.y_turn, y0_) - y0_;
      const double xs = x0_ + alpha * (curve.x_turn - x0_);
      const double ysp = pattern_.at(xs).y;
      const Piece right{1.0 / (curve.x_turn - xs), yu_ - ysp > tiny_ ? 1.0 / (yu_ - ysp) : 0.0};
      const Piece left{1.0 / (xs - x0_), ysp - y0_ > tiny_ ? 1.0 / (ysp - y0_) : 0.0};
      for (std::size_t i = 0; i < curve.x.size(); ++i, ++k) {
        const double x = curve.x[i];
        offset_[k] = y0_;
        slope_[k] = 0.0;
        // Each sample is offset + beta_d x slope, Eqs (15)-(19); a saturated piece is linear [A12].
        if (x >= curve.x_turn) {
          offset_[k] = y0_ + depth;
        } else if (x > x0_ && x >= xs) {
          double share = (x - xs) * right.by_x;
          if (right.by_y > 0.0) share = (pattern_.at(xs + (xu_ - xs) * share).y - ysp) * right.by_y;
          offset_[k] = y0_ + depth * share;
          slope_[k] = depth * (1.0 - share);
        } else if (x > x0_) {
          slope_[k] = depth * (left.by_y > 0.0 ? rise_[k] * left.by_y : (x - x0_) * left.by_x);
        }
        const double residual = curve.y[i] - offset_[k];
        gg += curve.weight[i] * slope_[k] * slope_[k];
        gr += curve.weight[i] * slope_[k] * residual;
      }
    }
    Value value{0.0, alpha, gg > 0.0 ? std::clamp(gr / gg, 0.0, 1.0) : 1.0};
    k = 0;
    for (const CurveSamples& curve : curves_) {
      for (std::size_t i = 0; i < curve.x.size(); ++i, ++k) {
        const double residual = curve.y[i] - offset_[k] - value.beta * slope_[k];
        value.j += curve.weight[i] * residual * residual;
      }
    }
    return value;
  }

 private:
  struct Piece {
    double by_x, by_y;  // 1 / extent; by_y 0: saturated
  };
  std::span<const CurveSamples> curves_;
  Knots pattern_;
  double x0_, xu_, y0_, yu_, tiny_;
  std::vector<double> rise_;            // of the pattern at each sample
  std::vector<double> slope_, offset_;  // of the last alpha_d
};

// Narrows the bracket about `best` 4 times each round.
Value refine(DescendingError& error, Value best, double& half_width, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    const double low = std::max(0.0, best.alpha - half_width), high = std::min(1.0, best.alpha + half_width);
    for (int k = 0; k <= kDivisions; ++k) {
      const Value value = error(low + (high - low) * k / kDivisions);
      if (value.j < best.j) best = value;
    }
    half_width *= 2.0 / kDivisions;
  }
  return best;
}

}  // namespace

double fit_descending(ElamModel& model, std::span<const CurveSamples> curves) {
  DescendingError error(model, curves);
  std::array<Value, kGrid + 1> grid;
  for (int i = 0; i <= kGrid; ++i) grid[static_cast<std::size_t>(i)] = error(static_cast<double>(i) / kGrid);
  std::vector<Value> minima;
  for (std::size_t i = 0; i <= kGrid; ++i)
    if ((i == 0 || grid[i].j <= grid[i - 1].j) && (i == kGrid || grid[i].j < grid[i + 1].j)) minima.push_back(grid[i]);
  if (minima.empty()) minima.push_back(grid[kGrid / 2]);  // J the same everywhere
  std::ranges::stable_sort(minima, {}, &Value::j);
  minima.resize(std::min<std::size_t>(minima.size(), kBrackets));
  Value best;
  double width = 0.0;
  for (const Value& minimum : minima) {
    width = 1.0 / kGrid;
    const Value value = refine(error, minimum, width, kFirstRounds);
    if (value.j < best.j) best = value;
  }
  best = refine(error, best, width, kLastRounds);
  model.parameters.alpha_d = best.alpha;
  model.parameters.beta_d = best.beta;
  return best.j;
}

}  // namespace tactbench::analysis
