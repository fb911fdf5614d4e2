#include "analysis/identify/rivals/gpi_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tactbench::analysis {
namespace {

constexpr double kConverged = 1e-12;  // share by which J fell
constexpr double kLargestDamping = 1e9;

using GpiVector = Eigen::Matrix<double, kGpiUnknowns, 1>;
using GpiMatrix = Eigen::Matrix<double, kGpiUnknowns, kGpiUnknowns>;

// The unknowns stay where exponentials are harmless.
GpiPoint within(const GpiVector& to) {
  const double low = std::log(1e-3), high = std::log(60.0);
  GpiPoint p;
  for (int k = 0; k < kGpiUnknowns; ++k) p[static_cast<std::size_t>(k)] = std::isfinite(to[k]) ? to[k] : 0.0;
  for (const auto k : {kLnA, kLnB}) p[k] = std::clamp(p[k], low, high);
  for (const auto k : {kLnDl, kLnDr}) p[k] = std::clamp(p[k], -20.0, 10.0);
  p[kLnAlpha] = std::clamp(p[kLnAlpha], -10.0, 4.0);
  p[kS] = std::clamp(p[kS], -8.0, 20.0);
  for (const auto k : {kL0, kR0}) p[k] = std::clamp(p[k], -1e3, 1e3);
  return p;
}

GpiVector vector_of(const GpiPoint& p) { return Eigen::Map<const GpiVector>(p.data()); }

// The normal equations in one lane.
struct GpiNormal {
  GpiMatrix matrix;
  GpiVector slope;
  GpiNormal() = default;
  GpiNormal(const GpiLanes& lanes, std::size_t lane) {
    for (int a = 0, k = 0; a < kGpiUnknowns; ++a) {
      slope[a] = lanes.slope[static_cast<std::size_t>(a)][lane];
      for (int b = 0; b <= a; ++b, ++k) matrix(a, b) = matrix(b, a) = lanes.normal[static_cast<std::size_t>(k)][lane];
    }
  }
};

struct Descent {
  GpiNormal here;
  GpiPoint to{};
  double damping = 1e-2, faster = 2.0;
  bool begun = false;

  void aim(const GpiPoint& from) {
    GpiMatrix damped = here.matrix;
    for (int k = 0; k < kGpiUnknowns; ++k) damped(k, k) += damping * (here.matrix(k, k) + 1e-9);
    to = within(vector_of(from) - damped.ldlt().solve(here.slope));
  }
  // Takes what was found at `to`; false: settled.
  bool take(GpiFound& best, double j, const GpiLanes& lanes, std::size_t lane) {
    if (!begun) {
      begun = true;
      if (!std::isfinite(j)) return false;  // best.j is infinite
      best = {to, j};
      here = GpiNormal(lanes, lane);
      return true;
    }
    if (!(j < best.j)) {
      damping *= faster;
      faster *= 2.0;
      return damping < kLargestDamping;
    }
    const GpiVector moved = vector_of(to) - vector_of(best.at);
    const double promised = -moved.dot(2.0 * here.slope + here.matrix * moved);
    const double kept = promised > 0.0 ? (best.j - j) / promised : 0.0;
    damping *= std::clamp(1.0 - std::pow(2.0 * kept - 1.0, 3.0), 1.0 / 3.0, 2.0);  // after Nielsen
    faster = 2.0;
    const bool converged = best.j - j <= kConverged * best.j;
    best = {to, j};
    here = GpiNormal(lanes, lane);
    return !converged;
  }
};

constexpr std::size_t kOffspring = 32, kParents = 16;
constexpr double kMeanLength = 2.7416;  // of a normal vector in 8 dimensions

// What does not change from one evolution to the next: weights, and the constants that follow from them.
struct GpiStrategy {
  std::array<double, kParents> weight{};
  double mass = 0.0, path_share = 0.0, path_damping = 0.0, way_share = 0.0, rank_one = 0.0, rank_many = 0.0;
  GpiStrategy() {
    constexpr double n = kGpiUnknowns;
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < kParents; ++i)
      sum += weight[i] = std::log(kParents + 0.5) - std::log(1.0 + static_cast<double>(i));
    for (double& w : weight) {
      w /= sum;
      squares += w * w;
    }
    mass = 1.0 / squares;
    path_share = (mass + 2.0) / (n + mass + 5.0);
    path_damping = 1.0 + path_share;
    way_share = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
    rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + mass);
    rank_many = std::min(1.0 - rank_one, 2.0 * (mass - 2.0 + 1.0 / mass) / ((n + 2.0) * (n + 2.0) + mass));
  }
};

// Nearly normal variates: sums of four 16-bit parts of xorshift numbers.
struct Variates {
  std::uint64_t state = 88172645463325252ULL;
  double operator()() {
    state ^= state << 13U;
    state ^= state >> 7U;
    state ^= state << 17U;
    const std::uint64_t sum =
        (state & 0xffffU) + ((state >> 16U) & 0xffffU) + ((state >> 32U) & 0xffffU) + (state >> 48U);
    return (static_cast<double>(sum) / 65536.0 - 2.0) * 1.7320508;
  }
};

}  // namespace

GpiParameters gpi_parameters(const GpiPoint& p, double x_span, double y_span) {
  GpiParameters found;
  const auto envelope = [&](double ln_a, double start, double ln_rise, double& a0, double& a1, double& a3) {
    const double a = std::exp(ln_a);
    a0 = y_span * std::exp(ln_rise) / -std::expm1(-a);
    a1 = a / x_span;
    a3 = y_span * start + a0;
  };
  envelope(p[kLnA], p[kL0], p[kLnDl], found.a0, found.a1, found.a3);
  envelope(p[kLnB], p[kR0], p[kLnDr], found.b0, found.b1, found.b3);
  found.alpha = y_span * std::exp(p[kLnAlpha]);
  found.tau = p[kS] / found.alpha;
  return found;
}

void GpiSearch::descend(std::span<GpiFound> found, int steps) {
  std::vector<Descent> descents(found.size());
  std::vector<std::size_t> active;
  for (std::size_t i = 0; i < found.size(); ++i) {
    active.push_back(i);
    descents[i].to = within(vector_of(found[i].at));
    found[i].j = std::numeric_limits<double>::infinity();
  }
  for (int step = 0; step <= steps && !active.empty(); ++step) {
    std::vector<std::size_t> going;
    for (std::size_t first = 0; first < active.size(); first += GpiLanes::kMost) {
      const std::size_t count = std::min(GpiLanes::kMost, active.size() - first);
      for (std::size_t lane = 0; lane < count; ++lane) lanes_.at[lane] = descents[active[first + lane]].to;
      lanes_.evaluate(*target_, true);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const std::size_t i = active[first + lane];
        if (!descents[i].take(found[i], lanes_.j[lane], lanes_, lane)) continue;
        descents[i].aim(found[i].at);
        going.push_back(i);
      }
    }
    active = std::move(going);
  }
}

GpiPoint GpiSearch::errors(const GpiFound& found, double variance) {
  lanes_.at.fill(found.at);
  lanes_.evaluate(*target_, true);
  const GpiNormal normal(lanes_, 0);
  const Eigen::SelfAdjointEigenSolver<GpiMatrix> solver(normal.matrix);
  const GpiVector spread =
      (variance / solver.eigenvalues().array().max(1e-14 * std::max(normal.matrix.trace(), 1e-12))).matrix();
  GpiPoint errors{};
  for (int k = 0; k < kGpiUnknowns; ++k)
    errors[static_cast<std::size_t>(k)] = std::sqrt(solver.eigenvectors().row(k).cwiseAbs2().dot(spread));
  return errors;
}

GpiFound GpiSearch::evolve(const GpiFound& start, double size, int generations) {
  static const GpiStrategy strategy;
  const auto& [weight, mass, path_share, path_damping, way_share, rank_one, rank_many] = strategy;
  lanes_.at.fill(start.at);
  lanes_.evaluate(*target_, true);
  GpiMatrix normal = GpiNormal(lanes_, 0).matrix;
  // What J hardly depends on shall not run away.
  for (int k = 0; k < kGpiUnknowns; ++k) normal(k, k) = normal(k, k) * (1.0 + 1e-6) + 1e-3 * start.j;
  const Eigen::LLT<GpiMatrix> metric(normal);

  Variates variate;
  GpiFound best = start;
  GpiVector mean = GpiVector::Zero(), path = GpiVector::Zero(), way = GpiVector::Zero();
  GpiMatrix covariance = GpiMatrix::Identity();
  const double unit = std::sqrt(start.j), smallest = 1e-5 * unit;
  size *= unit;
  double fading = 1.0;
  std::array<GpiVector, kOffspring> z, y;
  std::array<GpiFound, kOffspring> tried;
  std::array<std::size_t, kOffspring> order{};
  for (int generation = 0; generation < generations && size > smallest; ++generation) {
    const GpiMatrix shape = Eigen::LLT<GpiMatrix>(covariance).matrixL();
    for (std::size_t i = 0; i < kOffspring; ++i) {
      for (double& value : z[i]) value = variate();
      y[i] = shape * z[i];
      tried[i].at = within(vector_of(start.at) + metric.matrixU().solve(GpiVector(mean + size * y[i])));
      order[i] = i;
    }
    for (std::size_t first = 0; first < kOffspring; first += GpiLanes::kMost) {
      for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) lanes_.at[lane] = tried[first + lane].at;
      lanes_.evaluate(*target_, false);
      for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) tried[first + lane].j = lanes_.j[lane];
    }
    std::ranges::sort(order, {}, [&](std::size_t i) { return tried[i].j; });
    if (tried[order[0]].j < best.j) best = tried[order[0]];
    GpiVector mean_y = GpiVector::Zero(), mean_z = GpiVector::Zero();
    GpiMatrix many = GpiMatrix::Zero();
    for (std::size_t i = 0; i < kParents; ++i) {
      mean_y += weight[i] * y[order[i]];
      mean_z += weight[i] * z[order[i]];
      many.noalias() += weight[i] * y[order[i]] * y[order[i]].transpose();
    }
    mean += size * mean_y;
    path = (1.0 - path_share) * path + std::sqrt(path_share * (2.0 - path_share) * mass) * mean_z;
    fading *= (1.0 - path_share) * (1.0 - path_share);
    const double length = path.norm();
    const bool steady = length < (1.4 + 2.0 / 9.0) * kMeanLength * std::sqrt(1.0 - fading);
    way *= 1.0 - way_share;
    if (steady) way += std::sqrt(way_share * (2.0 - way_share) * mass) * mean_y;
    covariance = (1.0 - rank_one - rank_many) * covariance + rank_one * way * way.transpose() + rank_many * many;
    size *= std::exp(path_share / path_damping * (length / kMeanLength - 1.0));
  }
  return best;
}

}  // namespace tactbench::analysis
