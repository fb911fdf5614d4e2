#include "analysis/statistics/figures/sweep_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kZeroShare = 0.01;  // of the range: a repeat this near to the lowest level begins or ends there

// For each step of a sequence: the index of its LevelReadings, or -1; and the number of its branch.
struct LevelOfStep {
  int level = -1, branch = 0;
};

std::vector<LevelOfStep> levels_of_steps(const SequenceData& data, const std::vector<double>& grid) {
  const std::vector<StepKind> kinds = step_kinds(data, grid.front(), grid.back());
  std::vector<LevelOfStep> levels(kinds.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const double commanded = data.repeats.front().steps[i].setpoint_psi;
    const auto at = std::ranges::lower_bound(grid, commanded - kSameLevelPsi);
    if (!kinds[i].full || at == grid.end() || std::abs(*at - commanded) > kSameLevelPsi) continue;
    levels[i] = {static_cast<int>(at - grid.begin()) + (kinds[i].up ? 0 : static_cast<int>(grid.size())),
                 kinds[i].branch};
  }
  return levels;
}

void measure_zero_return(const Dataset& dataset, double low, double near, SweepErrors& errors) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<std::vector<double>> returns(width);
  for (const SequenceData& data : dataset.sequences) {
    for (const Repeat& repeat : data.repeats) {
      if (repeat.steps.size() < 3 || repeat.steps.front().setpoint_psi - low > near ||
          repeat.steps.back().setpoint_psi - low > near)
        continue;
      ++errors.repeats_with_zero;
      const std::size_t last = (repeat.steps.size() - 1) * width;
      for (std::size_t taxel = 0; taxel < width; ++taxel)
        returns[taxel].push_back(repeat.volts[last + taxel] - repeat.volts[taxel]);
    }
  }
  for (const std::vector<double>& own : returns) {
    errors.zero_return_v.push_back(mean_of(own));
    errors.zero_return_s_v.push_back(own.size() == 1 ? 0.0 : sample_deviation(own));
  }
}

}  // namespace

SweepErrors sweep_errors(const Dataset& dataset, const SensorModel& fit, int threads) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  const std::vector<double>& grid = fit.pressure_psi;
  SweepErrors errors;
  for (const bool up : {true, false})
    for (const double pressure : grid) errors.levels.push_back({pressure, up, 0, {}, {}});
  std::vector<std::vector<LevelOfStep>> level_of_step;
  std::map<std::pair<std::size_t, int>, int> groups;  // by sequence and branch
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    level_of_step.push_back(levels_of_steps(dataset.sequences[s], grid));
    for (const LevelOfStep& step : level_of_step.back())
      if (step.level >= 0) groups.try_emplace({s, step.branch}, static_cast<int>(groups.size()));
  }
  errors.groups = static_cast<int>(groups.size());
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s)
    for (std::size_t r = 0; r < dataset.sequences[s].repeats.size(); ++r)
      for (const LevelOfStep& step : level_of_step[s]) {
        if (step.level < 0) continue;
        LevelReadings& level = errors.levels[static_cast<std::size_t>(step.level)];
        ++level.readings;
        level.group.push_back(groups.at({s, step.branch}));
      }
  for (LevelReadings& level : errors.levels) level.error_psi.assign(level.readings * width, kNan);
  measure_zero_return(dataset, grid.front(), kZeroShare * (grid.back() - grid.front()), errors);

  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel, filled = std::vector<std::size_t>(errors.levels.size(), 0)](
               std::size_t s, std::size_t r, std::size_t i, const Compensated& now) mutable {
      if (level_of_step[s][i].level < 0) return;
      const auto level = static_cast<std::size_t>(level_of_step[s][i].level);
      errors.levels[level].error_psi[filled[level]++ * width + taxel] =
          now.pressure_psi - dataset.sequences[s].repeats[r].steps[i].reference_psi;
    };
  });
  return errors;
}

std::vector<double> mean_errors(const SweepErrors& errors, std::size_t taxels) {
  std::vector<double> means;
  for (const LevelReadings& level : errors.levels)
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      std::vector<double> own;
      for (std::size_t i = 0; i < level.readings; ++i) own.push_back(level.error_psi[i * taxels + taxel]);
      means.push_back(mean_by_shares(own));
    }
  return means;
}

namespace {

constexpr double kSweepEndShare = 0.01;  // a sweep is full when its ends are this near to the models' range

// A full loading sweep: where its steps stand in the dataset.
struct FullSweep {
  std::size_t sequence, repeat, first, last;
};

std::vector<double> setpoints_of(const Dataset& dataset, const FullSweep& sweep) {
  const auto& steps = dataset.sequences[sweep.sequence].repeats[sweep.repeat].steps;
  std::vector<double> out;
  for (std::size_t i = sweep.first; i <= sweep.last; ++i) out.push_back(steps[i].setpoint_psi);
  return out;
}

std::vector<FullSweep> full_sweeps(const Dataset& dataset, double low, double high) {
  const double end = kSweepEndShare * (high - low);
  std::vector<FullSweep> sweeps;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      std::vector<double> x;
      for (const Sample& step : repeats[r].steps) x.push_back(step.setpoint_psi);
      for (const Branch& branch : branches_along(x)) {
        const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
        if (!branch.ascending || x[first] > low + end || x[last] < high - end) continue;
        const FullSweep sweep{s, r, first, last};
        if (sweeps.empty() || setpoints_of(dataset, sweep) == setpoints_of(dataset, sweeps.front()))
          sweeps.push_back(sweep);
      }
    }
  }
  return sweeps;
}

}  // namespace

double SweepEstimates::mean(std::size_t level, int taxel) const {
  double sum = 0.0;
  for (int sweep = 0; sweep < sweeps; ++sweep) sum += at(level, sweep, taxel);
  return sum / sweeps;
}

SweepEstimates sweep_estimates(const Dataset& dataset, const SensorModel& fit, int threads) {
  check_same_sensor(dataset, fit);
  if (fit.falling) {
    SensorModel rising = fit;
    rising.falling = false;
    return sweep_estimates(as_modelled(dataset, fit), rising, threads);
  }
  const std::vector<FullSweep> sweeps = full_sweeps(dataset, fit.pressure_psi.front(), fit.pressure_psi.back());
  if (sweeps.empty())
    throw AnalysisError("TB-ANALYSIS-NO-LOOP",
                        fmt::format("run {} has no full sweep from {}", dataset.run,
                                    both_units_span(fit.pressure_psi.front(), fit.pressure_psi.back())),
                        "compare runs of recipes with full loops: descending, ascending, production");
  const auto width = static_cast<std::size_t>(dataset.taxels());
  SweepEstimates out;
  out.pressure_psi = setpoints_of(dataset, sweeps.front());
  out.sweeps = static_cast<int>(sweeps.size());
  out.taxels = dataset.taxels();
  out.psi.assign(out.pressure_psi.size() * sweeps.size() * width, kNan);
  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel, next = std::size_t{0}](  // next: sweep
               std::size_t s, std::size_t r, std::size_t i, const Compensated& now) mutable {
      const auto is_over = [&](const FullSweep& sweep) {
        return std::tie(sweep.sequence, sweep.repeat, sweep.last) < std::tie(s, r, i);
      };
      while (next < sweeps.size() && is_over(sweeps[next])) ++next;
      if (next == sweeps.size()) return;
      const FullSweep& sweep = sweeps[next];
      if (sweep.sequence != s || sweep.repeat != r || i < sweep.first) return;
      const Sample& sample = dataset.sequences[s].repeats[r].steps[i];
      out.psi[((i - sweep.first) * sweeps.size() + next) * width + taxel] =
          now.pressure_psi + sample.setpoint_psi - sample.reference_psi;
    };
  });
  return out;
}

}  // namespace tactbench::analysis
