#include "analysis/statistics/figures/sweep_errors.h"

#include <algorithm>
#include <cmath>

#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

constexpr double kFullSweepShare = 0.01;  // as external_loop
constexpr double kSameLevelPsi = 1e-6;

// For each step of a sequence: the index of its LevelReadings, or -1.
using LevelOfStep = std::vector<int>;

LevelOfStep levels_of_steps(const SequenceData& data, const std::vector<double>& grid) {
  const std::vector<Sample>& steps = data.repeats.front().steps;
  std::vector<double> commanded;
  for (const Sample& step : steps) commanded.push_back(step.setpoint_psi);
  LevelOfStep level(steps.size(), -1);
  const double low = grid.front(), high = grid.back(), near = kFullSweepShare * (high - low);
  for (const Branch& branch : branches_along(commanded)) {
    const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
    const double bottom = std::min(commanded[first], commanded[last]),
                 top = std::max(commanded[first], commanded[last]);
    if (bottom - low > near || high - top > near) continue;
    // The turning point closes the branch before it: there the reading is that branch's.
    for (std::size_t i = first == 0 ? first : first + 1; i <= last; ++i) {
      const auto at = std::ranges::lower_bound(grid, commanded[i] - kSameLevelPsi);
      if (at == grid.end() || std::abs(*at - commanded[i]) > kSameLevelPsi) continue;
      level[i] = static_cast<int>(at - grid.begin()) + (branch.ascending ? 0 : static_cast<int>(grid.size()));
    }
  }
  return level;
}

void measure_zero_return(const Dataset& dataset, double low, double near, SweepErrors& errors) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  errors.zero_return_v.assign(width, kNan);
  for (const SequenceData& data : dataset.sequences) {
    for (const Repeat& repeat : data.repeats) {
      if (repeat.steps.size() < 3 || repeat.steps.front().setpoint_psi - low > near ||
          repeat.steps.back().setpoint_psi - low > near)
        continue;
      ++errors.repeats_with_zero;
      const std::size_t last = (repeat.steps.size() - 1) * width;
      for (std::size_t taxel = 0; taxel < width; ++taxel) {
        const double off = std::abs(repeat.volts[last + taxel] - repeat.volts[taxel]);
        double& largest = errors.zero_return_v[taxel];
        largest = std::isnan(largest) ? off : std::max(largest, off);
      }
    }
  }
}

}  // namespace

SweepErrors sweep_errors(const Dataset& dataset, const SensorModel& fit, int threads) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  const std::vector<double>& grid = fit.pressure_psi;
  SweepErrors errors;
  for (const bool up : {true, false})
    for (const double pressure : grid) errors.levels.push_back({pressure, up, 0, {}});
  std::vector<LevelOfStep> level_of_step;
  for (const SequenceData& data : dataset.sequences) {
    level_of_step.push_back(levels_of_steps(data, grid));
    for (const int level : level_of_step.back())
      if (level >= 0) errors.levels[static_cast<std::size_t>(level)].readings += data.repeats.size();
  }
  for (LevelReadings& level : errors.levels) level.error_psi.assign(level.readings * width, kNan);
  measure_zero_return(dataset, grid.front(), kFullSweepShare * (grid.back() - grid.front()), errors);

  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel, filled = std::vector<std::size_t>(errors.levels.size(), 0)](
               std::size_t s, std::size_t r, std::size_t i, const Compensated& now) mutable {
      if (level_of_step[s][i] < 0) return;
      const auto level = static_cast<std::size_t>(level_of_step[s][i]);
      errors.levels[level].error_psi[filled[level]++ * width + taxel] =
          now.pressure_psi - dataset.sequences[s].repeats[r].steps[i].reference_psi;
    };
  });
  return errors;
}

}  // namespace tactbench::analysis
