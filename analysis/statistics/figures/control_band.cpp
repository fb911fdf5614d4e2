#include "analysis/statistics/figures/control_band.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>
#include <vector>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/numbers/student.h"

namespace tactbench::analysis {
namespace {

bool every_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

// P(|S| >= |s|) for n values in random order: the number of inversions k = (n (n - 1) / 2 - S) / 2 is spread as the
// product of uniform choices 0..j, j < n.
double exact_two_sided(int n, long s) {
  std::vector<double> share = {1.0};
  for (int j = 1; j < n; ++j) {
    std::vector<double> next(share.size() + static_cast<std::size_t>(j), 0.0);
    for (std::size_t k = 0; k < share.size(); ++k)
      for (int step = 0; step <= j; ++step) next[k + static_cast<std::size_t>(step)] += share[k] / (j + 1);
    share = std::move(next);
  }
  const long pairs = static_cast<long>(n) * (n - 1) / 2;
  double probability = 0.0;
  for (std::size_t k = 0; k < share.size(); ++k)
    if (std::labs(pairs - 2 * static_cast<long>(k)) >= std::labs(s)) probability += share[k];
  return std::min(1.0, probability);
}

double approximate_two_sided(std::span<const double> values, long s) {
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const auto term = [](double t) { return t * (t - 1.0) * (2.0 * t + 5.0); };
  double variance = term(static_cast<double>(values.size()));
  for (auto first = sorted.begin(); first != sorted.end();) {
    const auto last = std::upper_bound(first, sorted.end(), *first);
    variance -= term(static_cast<double>(last - first));
    first = last;
  }
  variance /= 18.0;
  if (s == 0 || variance <= 0.0) return 1.0;
  const double z = (static_cast<double>(std::labs(s)) - 1.0) / std::sqrt(variance);
  return std::erfc(z / std::numbers::sqrt2);
}

}  // namespace

std::optional<ControlBand> control_band(std::span<const double> values, double false_alarm) {
  if (values.size() < 3 || !every_finite(values)) return std::nullopt;
  const double n = static_cast<double>(values.size());
  ControlBand band;
  band.values = static_cast<int>(values.size());
  band.mean = mean_of(values);
  band.deviation = sample_deviation(values);
  const double half =
      std::max(student_quantile(1.0 - false_alarm / 2.0, n - 1.0) * band.deviation * std::sqrt(1.0 + 1.0 / n),
               1e-9 * std::abs(band.mean));
  band.low = band.mean - half;
  band.high = band.mean + half;
  return band;
}

std::optional<MonotoneTrend> monotone_trend(std::span<const double> values) {
  if (values.size() < 4 || !every_finite(values)) return std::nullopt;
  long s = 0;
  bool ties = false;
  std::vector<double> slopes;
  for (std::size_t j = 1; j < values.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      s += values[j] > values[i] ? 1 : values[j] < values[i] ? -1 : 0;
      ties = ties || values[j] == values[i];
      slopes.push_back((values[j] - values[i]) / static_cast<double>(j - i));
    }
  MonotoneTrend trend;
  const bool exact = !ties && values.size() <= 20;
  trend.probability = exact ? exact_two_sided(static_cast<int>(values.size()), s) : approximate_two_sided(values, s);
  trend.slope = median_of(std::move(slopes));
  trend.moved = trend.slope * static_cast<double>(values.size() - 1);
  return trend;
}

}  // namespace tactbench::analysis
