#include "analysis/identify/rivals/gpi_evolution.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactbench::analysis {
namespace {

constexpr std::size_t kGpiOffspring = 32, kGpiParents = 16;
constexpr double kGpiMeanLength = 2.7416;  // of a normal vector in 8 dimensions
constexpr double kSmallestStep = 1e-5;     // times the root of J
constexpr double kOpenCurvature = 1e-3;    // times J: what J hardly depends on shall not run away

}  // namespace

GpiEvolution::GpiEvolution(GpiLanes& lanes, const GpiTree::Target& target, const GpiFound& start, double size)
    : start_(start), best_(start), size_(size * std::sqrt(start.j)), smallest_(kSmallestStep * std::sqrt(start.j)) {
  lanes.at.fill(start.at);
  lanes.evaluate(target, true);
  GpiMatrix normal = GpiNormal(lanes, 0).matrix;
  for (int k = 0; k < kGpiUnknowns; ++k) normal(k, k) = normal(k, k) * (1.0 + 1e-6) + kOpenCurvature * start.j;
  metric_.compute(normal);
}

void GpiEvolution::go(GpiLanes& lanes, const GpiTree::Target& target, int last) {
  for (; generation_ < last && size_ > smallest_; ++generation_) generation(lanes, target);
}

void GpiEvolution::generation(GpiLanes& lanes, const GpiTree::Target& target) {
  static const EvolutionConstants<kGpiParents, kGpiUnknowns> constants;
  const auto& [weight, mass, path_share, path_damping, way_share, rank_one, rank_many] = constants;
  std::array<GpiVector, kGpiOffspring> z, y;
  std::array<GpiFound, kGpiOffspring> tried;
  std::array<std::size_t, kGpiOffspring> order{};
  const GpiMatrix shape = Eigen::LLT<GpiMatrix>(covariance_).matrixL();
  for (std::size_t i = 0; i < kGpiOffspring; ++i) {
    for (double& value : z[i]) value = variate_();
    y[i] = shape * z[i];
    tried[i].at = gpi_within(vector_of(start_.at) + metric_.matrixU().solve(GpiVector(mean_ + size_ * y[i])));
    order[i] = i;
  }
  for (std::size_t first = 0; first < kGpiOffspring; first += GpiLanes::kMost) {
    for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) lanes.at[lane] = tried[first + lane].at;
    lanes.evaluate(target, false);
    for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) tried[first + lane].j = lanes.j[lane];
  }
  std::ranges::sort(order, {}, [&](std::size_t i) { return tried[i].j; });
  if (tried[order[0]].j < best_.j) best_ = tried[order[0]];
  GpiVector mean_y = GpiVector::Zero(), mean_z = GpiVector::Zero();
  GpiMatrix many = GpiMatrix::Zero();
  for (std::size_t i = 0; i < kGpiParents; ++i) {
    mean_y += weight[i] * y[order[i]];
    mean_z += weight[i] * z[order[i]];
    many.noalias() += weight[i] * y[order[i]] * y[order[i]].transpose();
  }
  mean_ += size_ * mean_y;
  path_ = (1.0 - path_share) * path_ + std::sqrt(path_share * (2.0 - path_share) * mass) * mean_z;
  fading_ *= (1.0 - path_share) * (1.0 - path_share);
  const double length = path_.norm();
  const bool steady = length < (1.4 + 2.0 / 9.0) * kGpiMeanLength * std::sqrt(1.0 - fading_);
  way_ *= 1.0 - way_share;
  if (steady) way_ += std::sqrt(way_share * (2.0 - way_share) * mass) * mean_y;
  covariance_ = (1.0 - rank_one - rank_many) * covariance_ + rank_one * way_ * way_.transpose() + rank_many * many;
  size_ *= std::exp(path_share / path_damping * (length / kGpiMeanLength - 1.0));
}

}  // namespace tactbench::analysis
