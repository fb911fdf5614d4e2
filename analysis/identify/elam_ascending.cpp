// alpha_a1, alpha_a0, beta_a: with phi(L) = alpha_a1 L + alpha_a0 the split lies inside every branch exactly when u =
// phi(0) and v = phi(X) are in [0, 1], so the box is the unit cube in (u, v, beta_a). J is a narrow kinked valley in
// it: damped Gauss-Newton in (u, v) along a grid of beta_a, all three from the best minima, and a simplex for the
// kinks.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/identify/elam_samples.h"
#include "analysis/identify/knots.h"

namespace tactbench::analysis {
namespace {

using Point = Eigen::Vector3d;  // u, v, beta_a

constexpr int kGrid = 48;           // intervals of beta_a
constexpr int kGridSteps = 6;       // Gauss-Newton steps at each
constexpr std::size_t kMinima = 4;  // local minima over beta_a that are looked into
constexpr int kDivisions = 8;       // of the space between neighbours, each round
constexpr int kRounds = 2;
constexpr int kFollowSteps = 25;    // Gauss-Newton steps in all three
constexpr int kSimplexSteps = 160;  // per simplex
constexpr int kSimplexes = 2;       // of the best one after the other, each narrower

struct Value {
  double j = std::numeric_limits<double>::infinity();
  Point at = Point::Constant(0.5);
};

struct Gradient {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Point right = Point::Zero();
};

Point clip(const Point& p) { return p.cwiseMax(0.0).cwiseMin(1.0); }

class AscendingError {
 public:
  AscendingError(const ElamModel& model, std::span<const CurveSamples> curves)
      : pattern_(model.ascending), xu_(model.xu()), full_(model.xu() - model.x0()), yu_(model.yu()) {
    for (const CurveSamples& curve : curves) {
      Curve own{&curve, std::clamp(curve.y_turn, model.y0(), model.yu()), 0.0};
      own.xmp = pattern_.inverse(own.y_turn).x;
      curves_.push_back(own);
    }
  }

  // J at p; with `gradient` the Gauss-Newton normal equations too. Eqs (21)-(26).
  double operator()(const Point& p) const { return sum<false>(p, nullptr); }
  double operator()(const Point& p, Gradient& gradient) const { return sum<true>(p, &gradient); }

  // Where the mapping of the external branch is the identity: v that goes with beta_a.
  [[nodiscard]] double v_of(double beta, double y0) const {
    return (pattern_.inverse(y0 + beta * (yu_ - y0)).x - (xu_ - full_)) / full_;
  }

 private:
  struct Curve {
    const CurveSamples* samples;
    double y_turn, xmp;
  };

  template <bool kWithGradient>
  double sum(const Point& p, Gradient* gradient) const {
    double j = 0.0;
    for (const Curve& own : curves_) {
      const CurveSamples& curve = *own.samples;
      const double length = xu_ - curve.x_turn, share = length / full_;
      const double xs = curve.x_turn + (p[0] + (p[1] - p[0]) * share) * length;
      const Knots::Place split = pattern_.inverse(own.y_turn + p[2] * (yu_ - own.y_turn));
      // y = P(from + (to - from) part); part = (x - origin) / extent on either side of the split.
      const double extent_left = 1.0 / (xs - curve.x_turn), extent_right = 1.0 / (xu_ - xs);
      double nuu = 0.0, nus = 0.0, nss = 0.0, ru = 0.0, rs = 0.0;  // by xs and by the pattern's split
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        const double x = curve.x[i], weight = curve.weight[i];
        if (x <= curve.x_turn || x >= xu_) {
          const double residual = curve.y[i] - (x >= xu_ ? yu_ : own.y_turn);
          j += weight * residual * residual;
          continue;
        }
        const bool left = x <= xs;
        const double part = left ? (x - curve.x_turn) * extent_left : (x - xs) * extent_right;
        const double from = left ? own.xmp : split.x, to = left ? split.x : xu_;
        const Knots::Value model = pattern_.at(from + (to - from) * part);
        const double residual = curve.y[i] - model.y;
        j += weight * residual * residual;
        if constexpr (kWithGradient) {
          const double inside = left ? part : 1.0 - part;
          const double by_xs = -model.slope * (to - from) * inside * (left ? extent_left : extent_right);
          const double by_split = model.slope * inside;
          nuu += weight * by_xs * by_xs;
          nus += weight * by_xs * by_split;
          nss += weight * by_split * by_split;
          ru += weight * residual * by_xs;
          rs += weight * residual * by_split;
        }
      }
      if constexpr (kWithGradient) {
        const Point by_xs(length * (1.0 - share), length * share, 0.0);
        const Point by_split(0.0, 0.0, (yu_ - own.y_turn) / split.slope);
        gradient->normal += nuu * by_xs * by_xs.transpose() + nss * by_split * by_split.transpose() +
                            nus * (by_xs * by_split.transpose() + by_split * by_xs.transpose());
        gradient->right += ru * by_xs + rs * by_split;
      }
    }
    return j;
  }

  Knots pattern_;
  std::vector<Curve> curves_;
  double xu_, full_, yu_;
};

// Levenberg-Marquardt in the unit cube; beta_a stays where it is when `fixed_beta`.
Value descend(const AscendingError& error, const Point& start, int steps, bool fixed_beta) {
  Gradient gradient;
  Value best{error(start, gradient), start};
  double damping = 1e-3;
  for (int step = 0; step < steps; ++step) {
    // A parameter at its bound that would leave the cube rests.
    std::array<bool, 3> rests{};
    for (int i = 0; i < 3; ++i)
      rests[static_cast<std::size_t>(i)] = (i == 2 && fixed_beta) || gradient.normal(i, i) <= 0.0 ||
                                           (best.at[i] <= 0.0 && gradient.right[i] < 0.0) ||
                                           (best.at[i] >= 1.0 && gradient.right[i] > 0.0);
    Eigen::Matrix3d normal = gradient.normal;
    Point right = gradient.right;
    for (int i = 0; i < 3; ++i) {
      normal(i, i) *= 1.0 + damping;
      if (!rests[static_cast<std::size_t>(i)]) continue;
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1.0;
      right[i] = 0.0;
    }
    const Point move = normal.ldlt().solve(right);
    if (!move.allFinite()) break;
    const Point at = clip(best.at + move);
    Gradient there;
    const double j = error(at, there);
    if (j < best.j) {
      const bool settled = best.j - j <= 1e-13 * best.j;
      best = {j, at};
      gradient = there;
      damping = std::max(damping * 0.1, 1e-9);
      if (settled) break;
    } else {
      damping *= 8.0;
      if (damping > 1e7) break;
    }
  }
  return best;
}

// Nelder-Mead inside the cube: J's slope jumps where a sample crosses a knot, and the minimum may lie on such a kink.
Value simplex(const AscendingError& error, const Value& start, double size) {
  std::array<Value, 4> corners;
  corners[0] = start;
  for (std::size_t i = 0; i < 3; ++i) {
    Point at = start.at;
    at[static_cast<Eigen::Index>(i)] += at[static_cast<Eigen::Index>(i)] + size <= 1.0 ? size : -size;
    corners[i + 1] = {error(at), at};
  }
  const auto at = [&](const Point& p) { return Value{error(clip(p)), clip(p)}; };
  for (int step = 0; step < kSimplexSteps; ++step) {
    std::ranges::stable_sort(corners, {}, &Value::j);
    if ((corners[3].at - corners[0].at).cwiseAbs().maxCoeff() < 1e-11) break;
    const Point middle = (corners[0].at + corners[1].at + corners[2].at) / 3.0;
    const Point away = middle - corners[3].at;
    const Value reflected = at(middle + away);
    if (reflected.j < corners[0].j) {
      const Value expanded = at(middle + 2.0 * away);
      corners[3] = expanded.j < reflected.j ? expanded : reflected;
    } else if (reflected.j < corners[2].j) {
      corners[3] = reflected;
    } else {
      const Value contracted = reflected.j < corners[3].j ? at(middle + 0.5 * away) : at(middle - 0.5 * away);
      if (contracted.j < std::min(reflected.j, corners[3].j)) {
        corners[3] = contracted;
      } else {
        for (std::size_t i = 1; i < 4; ++i) corners[i] = at(corners[0].at + 0.5 * (corners[i].at - corners[0].at));
      }
    }
  }
  return *std::ranges::min_element(corners, {}, &Value::j);
}

// The best few local minima of a list along beta_a, best first.
std::vector<Value> minima_of(const std::vector<Value>& line) {
  std::vector<Value> minima;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((i == 0 || line[i].j <= line[i - 1].j) && (i + 1 == line.size() || line[i].j < line[i + 1].j))
      minima.push_back(line[i]);
  if (minima.empty()) minima.push_back(line.front());  // J the same everywhere
  std::ranges::stable_sort(minima, {}, &Value::j);
  minima.resize(std::min(minima.size(), kMinima));
  return minima;
}

// The line of beta_a about a minimum, from one neighbour (`width` away) to the other, each warm-started by the last.
void walk(const AscendingError& error, const Value& minimum, double width, std::vector<Value>& line) {
  std::vector<Value> below, above;
  for (const double sign : {-1.0, 1.0}) {
    std::vector<Value>& side = sign < 0.0 ? below : above;
    Value last = minimum;
    for (int k = 1; k < kDivisions; ++k) {
      Point start = last.at;
      start[2] = minimum.at[2] + sign * width * k / kDivisions;
      if (start[2] < 0.0 || start[2] > 1.0) break;
      last = descend(error, start, kGridSteps, true);
      side.push_back(last);
    }
  }
  line.insert(line.end(), below.rbegin(), below.rend());
  line.push_back(minimum);
  line.insert(line.end(), above.begin(), above.end());
}

}  // namespace

double fit_ascending(ElamModel& model, std::span<const CurveSamples> curves) {
  const AscendingError error(model, curves);
  std::vector<Value> grid;
  double u = 0.5;
  for (int i = 0; i <= kGrid; ++i) {
    const double beta = static_cast<double>(i) / kGrid, v = error.v_of(beta, model.y0());
    Value best = descend(error, Point(u, v, beta), kGridSteps, true);
    // The neighbour's u may lie in another valley than the middle's.
    const Value other = descend(error, Point(0.5, v, beta), kGridSteps, true);
    if (other.j < best.j) best = other;
    u = best.at[0];
    grid.push_back(best);
  }
  // J along the valley has dents narrower than the grid: look between its points.
  std::vector<Value> minima = minima_of(grid);
  double width = 1.0 / kGrid;
  for (int round = 0; round < kRounds; ++round, width /= kDivisions) {
    std::vector<Value> found;
    for (const Value& minimum : minima) {
      std::vector<Value> line;
      walk(error, minimum, width, line);
      const std::vector<Value> own = minima_of(line);
      found.insert(found.end(), own.begin(), own.end());
    }
    std::ranges::stable_sort(found, {}, &Value::j);
    found.resize(std::min(found.size(), kMinima));
    minima = std::move(found);
  }
  Value best;
  for (const Value& minimum : minima) {
    Value value = descend(error, minimum.at, kFollowSteps, false);
    if (value.j < best.j) best = value;
  }
  double size = 0.01;
  for (int i = 0; i < kSimplexes; ++i, size *= 0.1) {
    best = simplex(error, best, size);
    const Value followed = descend(error, best.at, kFollowSteps, false);
    if (followed.j < best.j) best = followed;
  }
  model.parameters.alpha_a0 = best.at[0];
  model.parameters.alpha_a1 = (best.at[1] - best.at[0]) / (model.xu() - model.x0());
  model.parameters.beta_a = best.at[2];
  return best.j;
}

}  // namespace tactbench::analysis
