#include "analysis/statistics/control/control_band.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

bool every_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
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

std::optional<double> theil_sen_slope(std::span<const double> values) {
  if (values.size() < 4 || !every_finite(values)) return std::nullopt;
  std::vector<double> slopes;
  for (std::size_t j = 1; j < values.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) slopes.push_back((values[j] - values[i]) / static_cast<double>(j - i));
  return median_of(std::move(slopes));
}

}  // namespace tactbench::analysis
