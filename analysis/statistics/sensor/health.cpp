#include "analysis/statistics/sensor/health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

constexpr int kLeastSwapLength = 8;  // taxels of a line: shorter ones are alike by chance

void gather_extremes(const Dataset& dataset, Health& health) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  health.low_v.assign(width, std::numeric_limits<double>::infinity());
  health.high_v.assign(width, -std::numeric_limits<double>::infinity());
  for (const SequenceData& sequence : dataset.sequences) {
    for (const Repeat& repeat : sequence.repeats) {
      for (std::size_t i = 0; i < repeat.volts.size(); ++i) {
        double &low = health.low_v[i % width], &high = health.high_v[i % width];
        low = std::min(low, repeat.volts[i]);
        high = std::max(high, repeat.volts[i]);
      }
    }
  }
}

std::string volts_range(const Health& health, std::size_t taxel) {
  return fmt::format("output {:.3f} V to {:.3f} V", health.low_v[taxel], health.high_v[taxel]);
}

// As a fit decides, where there is none.
TaxelStatus status_without_fit(const Dataset& dataset, const Health& health, std::size_t taxel) {
  const TaxelStatus status =
      status_of({health.low_v[taxel], health.high_v[taxel]}, dataset.at_limit[taxel], health.options.dead_v);
  const bool silent = status == TaxelStatus::kDead || status == TaxelStatus::kStuck;
  return silent && !health.loaded ? TaxelStatus::kFitted : status;
}

std::string reason_for(const Health& health, const ModelTaxel* fit, TaxelStatus status, std::size_t taxel) {
  std::string range = volts_range(health, taxel);
  switch (status) {
    case TaxelStatus::kFitted:
      break;
    case TaxelStatus::kDead:
      return fmt::format("{}: moves less than {:g} V, near 0 V", range, health.options.dead_v);
    case TaxelStatus::kStuck:
      return fmt::format("{}: moves less than {:g} V, away from 0 V", range, health.options.dead_v);
    case TaxelStatus::kSaturated:
      return fmt::format("{}: frame after frame stood at the converter's limit", range);
    case TaxelStatus::kConstant:
      return range;
    case TaxelStatus::kUnfit:
      if (fit == nullptr || !(fit->full_scale() > 0.0)) return range + ": moves, but not with the pressure";
      return fmt::format("{}: the model's mean error is {:.1f} % of the taxel's full scale", range,
                         100.0 * fit->fit.mean_error / fit->full_scale());
  }
  return {};
}

struct LineFrame {
  int rows, columns;
  bool along_rows;
  const std::vector<double>& values;
  [[nodiscard]] int lines() const { return along_rows ? rows : columns; }
  [[nodiscard]] int length() const { return along_rows ? columns : rows; }
  [[nodiscard]] double at(int line, int i) const {
    const int cell = along_rows ? line * columns + i : i * columns + line;
    return values[static_cast<std::size_t>(cell)];
  }
};

// Pearson's, of line a of one frame with line b of another, over the taxels that both frames tell of; 0 where one is
// constant or too few are left.
double line_correlation(const LineFrame& x, int a, const LineFrame& y, int b) {
  std::vector<double> of_x, of_y;
  for (int i = 0; i < x.length(); ++i) {
    if (!std::isfinite(x.at(a, i)) || !std::isfinite(y.at(b, i))) continue;
    of_x.push_back(x.at(a, i));
    of_y.push_back(y.at(b, i));
  }
  return of_x.size() < kLeastSwapLength ? 0.0 : line_fit(of_x, of_y).correlation();
}

}  // namespace

int Health::count(const std::string& state) const {
  return static_cast<int>(
      std::count_if(findings.begin(), findings.end(), [&](const TaxelHealth& t) { return t.state == state; }));
}

std::vector<SwappedLines> swapped_lines(int rows, int columns, const std::vector<double>& now,
                                        const std::vector<double>& before, const HealthOptions& options) {
  std::vector<SwappedLines> swaps;
  for (const bool along_rows : {true, false}) {
    const LineFrame after{rows, columns, along_rows, now}, first{rows, columns, along_rows, before};
    if (after.length() < kLeastSwapLength) continue;
    const auto best_place = [&](int line) {
      int best = 0;
      for (int other = 1; other < after.lines(); ++other)
        if (line_correlation(after, line, first, other) > line_correlation(after, line, first, best)) best = other;
      return best;
    };
    for (int a = 0; a < after.lines(); ++a) {
      const int b = best_place(a);
      if (b <= a || best_place(b) != a) continue;
      const double as_is = std::min(line_correlation(after, a, first, a), line_correlation(after, b, first, b));
      const double exchanged = std::min(line_correlation(after, a, first, b), line_correlation(after, b, first, a));
      if (exchanged < options.swap_correlation || exchanged < as_is + options.swap_margin) continue;
      swaps.push_back({along_rows, a, b, as_is, exchanged});
    }
  }
  return swaps;
}

Health health_of(const Dataset& dataset, const SensorModel& fit, bool loaded, const HealthOptions& options) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  if (!fit.taxels.empty() && fit.array().size() != width)
    throw std::invalid_argument("health_of: the fit has other taxels than the dataset");
  Health health;
  health.options = options;
  health.rows = dataset.rows;
  health.columns = dataset.columns;
  health.loaded = loaded;
  gather_extremes(dataset, health);
  const bool has_noise = std::ranges::any_of(dataset.noise_v, [](double noise) { return noise > 0.0; });
  if (has_noise) health.noise_v = dataset.noise_v;
  health.median_noise_v = median_of(health.noise_v);
  for (std::size_t taxel = 0; taxel < width; ++taxel) {
    const ModelTaxel* own = fit.taxels.empty() ? nullptr : &fit.taxels[taxel];
    const TaxelStatus status = own != nullptr ? own->status : status_without_fit(dataset, health, taxel);
    const int number = static_cast<int>(taxel);
    if (status != TaxelStatus::kFitted)
      health.findings.push_back({number, to_string(status), reason_for(health, own, status, taxel), true});
    if (has_noise && health.noise_v[taxel] > options.noisy_factor * health.median_noise_v)
      health.findings.push_back(
          {number, "noisy",
           fmt::format("noise {:.2f} mV, above {:g} times the median of {:.2f} mV", 1e3 * health.noise_v[taxel],
                       options.noisy_factor, 1e3 * health.median_noise_v),
           false});
  }
  return health;
}

}  // namespace tactbench::analysis
