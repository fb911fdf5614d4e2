#include "analysis/identify/elam/ascending_search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/elam/evolution.h"

namespace tactbench::analysis {
namespace {

double clip(double value) { return value > 0.0 ? std::min(value, 1.0) : 0.0; }  // what is no number to 0

// Cholesky's factor of a symmetric matrix (lower triangle row by row), its diagonal inverted.
struct Factor {
  std::array<double, 6> l{};
  Point diagonal{};
  explicit Factor(const std::array<double, 6>& a) {
    const auto root = [](double value) { return value > 0.0 ? std::sqrt(value) : 1.0; };
    l[0] = 1.0 / (diagonal[0] = root(a[0]));
    l[1] = a[1] * l[0];
    l[2] = 1.0 / (diagonal[1] = root(a[2] - l[1] * l[1]));
    l[3] = a[3] * l[0];
    l[4] = (a[4] - l[3] * l[1]) * l[2];
    l[5] = 1.0 / (diagonal[2] = root(a[5] - l[3] * l[3] - l[4] * l[4]));
  }
  [[nodiscard]] Point forward(const Point& b) const {  // L x = b
    Point x{};
    x[0] = b[0] * l[0];
    x[1] = (b[1] - l[1] * x[0]) * l[2];
    x[2] = (b[2] - l[3] * x[0] - l[4] * x[1]) * l[5];
    return x;
  }
  [[nodiscard]] Point backward(const Point& b) const {  // L' x = b
    Point x{};
    x[2] = b[2] * l[5];
    x[1] = (b[1] - l[4] * x[2]) * l[2];
    x[0] = (b[0] - l[1] * x[1] - l[3] * x[2]) * l[0];
    return x;
  }
  [[nodiscard]] Point times(const Point& z) const {  // L z
    return {diagonal[0] * z[0], l[1] * z[0] + diagonal[1] * z[1], l[3] * z[0] + l[4] * z[1] + diagonal[2] * z[2]};
  }
};

constexpr std::array<std::array<std::size_t, 3>, 3> kRow{{{0, 1, 3}, {1, 2, 4}, {3, 4, 5}}};

// The damped Gauss-Newton step. A parameter at its bound that would leave the cube rests, and one that J does not
// depend on.
Point damped_step(std::array<double, 6> a, Point b, double damping, const Point& at, bool plane) {
  for (std::size_t k = 0; k < (plane ? 2U : 3U); ++k) {
    const bool rests = a[kRow[k][k]] <= 0.0 || (at[k] <= 0.0 && b[k] < 0.0) || (at[k] >= 1.0 && b[k] > 0.0);
    a[kRow[k][k]] *= 1.0 + damping;
    if (!rests) continue;
    for (const std::size_t i : kRow[k]) a[i] = 0.0;
    a[kRow[k][k]] = 1.0;
    b[k] = 0.0;
  }
  if (plane) {
    const double by = 1.0 / (a[0] * a[2] - a[1] * a[1]);
    if (!(std::abs(by) < std::numeric_limits<double>::infinity())) return at;
    return {clip(at[0] + (b[0] * a[2] - b[1] * a[1]) * by), clip(at[1] + (b[1] * a[0] - b[0] * a[1]) * by), at[2]};
  }
  const Factor factor(a);
  const Point move = factor.backward(factor.forward(b));
  return {clip(at[0] + move[0]), clip(at[1] + move[1]), clip(at[2] + move[2])};
}

constexpr std::size_t kOffspring = 24, kParents = 12, kGenerations = 60;
constexpr int kDimensions = 3;
constexpr double kMeanLength = 1.596;  // of a normal vector

// What does not change from one evolution to the next.
struct Strategy {
  EvolutionConstants<kParents, kDimensions> constants;
  std::array<Point, kOffspring * kGenerations> variates{};
  Strategy() {
    Variates variate;
    for (Point& point : variates)
      for (double& value : point) value = variate();
  }
};

}  // namespace

void AscendingSearch::put(std::size_t i, const Point& at) {
  lanes_.u[i] = at[0];
  lanes_.v[i] = at[1];
  if (lanes_.beta[i] == at[2] && lanes_.is_split[i]) return;
  lanes_.beta[i] = at[2];
  lanes_.split(i);
}

void AscendingSearch::take(std::size_t i, Lane& lane, Gradient gradient) const {
  const std::size_t normals = gradient == Gradient::kSpace ? 6 : 3, rights = gradient == Gradient::kSpace ? 3 : 2;
  for (std::size_t k = 0; k < normals; ++k) lane.normal[k] = lanes_.normal[k][i];
  for (std::size_t k = 0; k < rights; ++k) lane.right[k] = lanes_.right[k][i];
}

void AscendingSearch::evaluate(std::span<Value> values) {
  if (values.size() > lanes_.stride) throw std::invalid_argument("more candidates than lanes");
  for (std::size_t i = 0; i < values.size(); ++i) put(i, values[i].at);
  lane_ascending(lanes_, values.size(), Gradient::kNone);
  for (std::size_t i = 0; i < values.size(); ++i) values[i].j = lanes_.j[i];
}

void AscendingSearch::descend(std::span<Value> values, int steps, Gradient gradient) {
  const std::size_t count = values.size();
  if (count > lanes_.stride) throw std::invalid_argument("more candidates than lanes");
  for (std::size_t i = 0; i < count; ++i) put(i, values[i].at);
  lane_ascending(lanes_, count, gradient);
  for (std::size_t i = 0; i < count; ++i) {
    at_[i] = {};
    values[i].j = lanes_.j[i];
    take(i, at_[i], gradient);
  }
  tried_.resize(count);
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      const Lane& lane = at_[i];
      tried_[i] = damped_step(lane.normal, lane.right, lane.damping, values[i].at, gradient == Gradient::kPlane);
      put(i, tried_[i]);
    }
    lane_ascending(lanes_, count, gradient);
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) {
      Lane& lane = at_[i];
      if (lanes_.j[i] < values[i].j) {
        lane.settled = values[i].j - lanes_.j[i] <= 1e-13 * values[i].j;
        values[i] = {lanes_.j[i], tried_[i]};
        take(i, lane, gradient);
        lane.damping = std::max(lane.damping * 0.1, 1e-9);
      } else {
        lane.damping *= 8.0;
        lane.settled = lane.settled || lane.damping > 1e7;
      }
      all = all && lane.settled;
    }
    if (all) break;
  }
}

Value AscendingSearch::evolve(const Value& start) {
  constexpr double kFirst = 0.0548, kLast = 1e-4;  // step sizes: at them J would rise by their square, as a share
  static const Strategy strategy;
  const auto& variates = strategy.variates;
  const auto& [weight, mass, path_share, path_damping, way_share, rank_one, rank_many] = strategy.constants;

  put(0, start.at);
  lane_ascending(lanes_, 1, Gradient::kSpace);
  Lane here;
  take(0, here, Gradient::kSpace);
  // What J hardly depends on shall not run away.
  for (std::size_t k = 0; k < 3; ++k) here.normal[kRow[k][k]] = here.normal[kRow[k][k]] * (1.0 + 1e-6) + 1e-6 * start.j;
  const Factor metric(here.normal);

  Value best = start;
  Point mean{}, path{}, way{};
  std::array<double, 6> covariance{1, 0, 1, 0, 0, 1};
  double size = kFirst * std::sqrt(start.j), fading = 1.0;
  const double smallest = kLast * std::sqrt(start.j);
  std::array<Value, kOffspring> tries;
  std::array<Point, kOffspring> y{};
  std::array<double, kOffspring> outside{};  // J, and what leaving the cube costs, that the mean stays inside
  std::array<std::size_t, kOffspring> order{};
  for (std::size_t generation = 0; generation < kGenerations && size > smallest; ++generation) {
    const Factor shape(covariance);
    const Point* z = &variates[generation * kOffspring];
    for (std::size_t i = 0; i < kOffspring; ++i) {
      y[i] = shape.times(z[i]);
      Point p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = mean[k] + size * y[i][k];
      const Point move = metric.backward(p);
      outside[i] = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        tries[i].at[k] = clip(start.at[k] + move[k]);
        const double off = start.at[k] + move[k] - tries[i].at[k];
        outside[i] += here.normal[kRow[k][k]] * off * off;
      }
      order[i] = i;
    }
    evaluate(tries);
    for (const Value& tried : tries)
      if (tried.j < best.j) best = tried;
    for (std::size_t i = 0; i < kOffspring; ++i) outside[i] += tries[i].j;
    std::ranges::sort(order, {}, [&](std::size_t i) { return outside[i]; });
    Point mean_y{}, mean_z{};
    for (std::size_t i = 0; i < kParents; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        mean_y[k] += weight[i] * y[order[i]][k];
        mean_z[k] += weight[i] * z[order[i]][k];
      }
    }
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      mean[k] += size * mean_y[k];
      path[k] = (1.0 - path_share) * path[k] + std::sqrt(path_share * (2.0 - path_share) * mass) * mean_z[k];
      length += path[k] * path[k];
    }
    length = std::sqrt(length);
    fading *= (1.0 - path_share) * (1.0 - path_share);
    const bool steady = length < (1.4 + 2.0 / (kDimensions + 1.0)) * kMeanLength * std::sqrt(1.0 - fading);
    for (std::size_t k = 0; k < 3; ++k)
      way[k] =
          (1.0 - way_share) * way[k] + (steady ? std::sqrt(way_share * (2.0 - way_share) * mass) * mean_y[k] : 0.0);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        double many = 0.0;
        for (std::size_t i = 0; i < kParents; ++i) many += weight[i] * y[order[i]][a] * y[order[i]][b];
        double& c = covariance[kRow[a][b]];
        c = (1.0 - rank_one - rank_many) * c + rank_one * way[a] * way[b] + rank_many * many;
      }
    }
    size *= std::exp(path_share / path_damping * (length / kMeanLength - 1.0));
  }
  return best;
}

}  // namespace tactbench::analysis
