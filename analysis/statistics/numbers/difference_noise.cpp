#include "analysis/statistics/numbers/difference_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kHighest = 6;          // order
constexpr std::size_t kEnough = 20;          // differences for a median
constexpr std::size_t kFew = 2;              // the same, of short histories
constexpr std::size_t kLooked = 20'000;      // differences an order that are looked at, of longer stretches every n-th
constexpr double kMedianOfNormal = 0.67449;  // of its absolute value, in standard deviations
using Weights = std::array<double, kHighest + 1>;

// Weights of the difference of the samples at `x`, `order` + 1 of them: 1 / prod (x_i - x_j) [divided difference], of
// unit norm, so that noise keeps its size. None where two inputs are one.
std::optional<Weights> weights_of(std::span<const double> x) {
  Weights weights{};
  const double length = x.back() - x.front() == 0.0 ? 1.0 : std::abs(x.back() - x.front());
  double norm = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double product = 1.0;
    for (std::size_t j = 0; j < x.size(); ++j)
      if (j != i) product *= (x[i] - x[j]) / length;
    if (product == 0.0) return std::nullopt;
    weights[i] = 1.0 / product;
    norm += weights[i] * weights[i];
  }
  norm = std::sqrt(norm);
  if (!std::isfinite(norm)) return std::nullopt;
  for (double& weight : weights) weight /= norm;
  return weights;
}

struct Estimate {
  double noise = 0.0;
  std::size_t count = 0;
};

Estimate estimate_of(std::span<const Stretch> stretches, std::size_t order, bool divided) {
  constexpr std::array<double, kHighest + 1> kEvenPlaces = {0, 1, 2, 3, 4, 5, 6};
  const Weights even = *weights_of(std::span(kEvenPlaces).first(order + 1));
  std::size_t all = 0;
  for (const Stretch& stretch : stretches) all += stretch.y.size() > order ? stretch.y.size() - order : 0;
  const std::size_t stride = 1 + all / kLooked;
  std::vector<double> sizes;
  for (const Stretch& stretch : stretches) {
    for (std::size_t i = 0; i + order < stretch.y.size(); i += stride) {
      const std::optional<Weights> weights = divided ? weights_of(stretch.x.subspan(i, order + 1)) : even;
      if (!weights) continue;
      double difference = 0.0;
      for (std::size_t k = 0; k <= order; ++k) difference += (*weights)[k] * stretch.y[i + k];
      sizes.push_back(std::abs(difference));
    }
  }
  const std::size_t count = sizes.size();
  return {count == 0 ? 0.0 : quantile_of(std::move(sizes), 0.5) / kMedianOfNormal, count};
}

}  // namespace

double difference_noise(std::span<const Stretch> stretches) {
  const bool placed = std::ranges::none_of(stretches, [](const Stretch& s) { return s.x.empty(); });
  std::vector<Estimate> estimates;
  for (std::size_t order = 1; order <= kHighest; ++order) {
    estimates.push_back(estimate_of(stretches, order, false));
    if (placed) estimates.push_back(estimate_of(stretches, order, true));
  }
  for (const std::size_t enough : {kEnough, kFew, std::size_t{1}}) {
    std::optional<double> least;
    for (const Estimate& own : estimates)
      if (own.count >= enough) least = std::min(least.value_or(own.noise), own.noise);
    if (least) return *least;
  }
  return 0.0;
}

}  // namespace tactbench::analysis
