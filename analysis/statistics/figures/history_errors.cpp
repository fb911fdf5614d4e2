#include "analysis/statistics/figures/history_errors.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/step_kinds.h"
#include "analysis/statistics/figures/streams.h"

namespace tactbench::analysis {
namespace {

// A step that counts, and the windows that it counts in.
struct CountedStep {
  std::size_t first = 0, end = 0;  // windows
  bool up = true;
  std::size_t frame = 0;  // of the frames that count, in time order
};

bool is_asked(BranchesOf which, const StepKind& kind) {
  return which == BranchesOf::kAll || kind.full == (which == BranchesOf::kFullSweeps);
}

class WindowSums {
 public:
  WindowSums(const SensorModel& fit, const LevelCorrections& corrections) : fit_(fit), corrections_(corrections) {
    for (const bool up : {true, false})
      for (const double pressure : fit.pressure_psi) {
        windows_.push_back({pressure, up, 0.0, 0.0, {}, {}, 0.0});
        windows_.back().mean_psi.assign(fit.array().size(), 0.0);
        windows_.back().square_psi.assign(fit.array().size(), 0.0);
      }
  }

  void add(const Dataset& run, BranchesOf which, int threads) {
    const std::size_t width = fit_.array().size();
    std::vector<std::vector<std::vector<int>>> counted;  // sequence, repeat, step: index of `steps`, or -1
    std::vector<CountedStep> steps;
    std::set<std::pair<std::size_t, std::pair<std::size_t, int>>> ways;  // window, sequence, branch
    for (std::size_t s = 0; s < run.sequences.size(); ++s) {
      const std::vector<StepKind> kinds =
          step_kinds(run.sequences[s], fit_.pressure_psi.front(), fit_.pressure_psi.back());
      counted.emplace_back();
      for (const Repeat& repeat : run.sequences[s].repeats) {
        counted.back().emplace_back(repeat.steps.size(), -1);
        for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
          const auto [first, end] = windows_of(repeat.steps[i].setpoint_psi, kinds[i].up);
          if (!is_asked(which, kinds[i]) || first == end) continue;
          counted.back().back()[i] = static_cast<int>(steps.size());
          steps.push_back({first, end, kinds[i].up, steps.size()});
          for (std::size_t w = first; w < end; ++w) {
            windows_[w].frames += 1.0;
            ways.insert({w, {s, kinds[i].branch}});
          }
        }
      }
    }
    for (const auto& way : ways) windows_[way.first].branches += 1.0;
    std::vector<double> errors(steps.size() * width, kNan);
    compensate_in_order(run, fit_, threads, [&](std::size_t taxel) {
      return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        if (counted[s][r][i] < 0) return;
        const auto at = static_cast<std::size_t>(counted[s][r][i]);
        const Sample& sample = run.sequences[s].repeats[r].steps[i];
        const double error = now.pressure_psi - sample.reference_psi -
                             correction_at(corrections_, fit_, taxel, sample.setpoint_psi, steps[at].up);
        errors[at * width + taxel] = error;
        for (std::size_t w = steps[at].first; w < steps[at].end; ++w) {
          windows_[w].mean_psi[taxel] += error;
          windows_[w].square_psi[taxel] += error * error;
        }
      };
    });
    for (const CountedStep& step : steps) {
      const double common = mean_of(finite_of(std::span(errors).subspan(step.frame * width, width)));
      for (std::size_t w = step.first; w < step.end; ++w) windows_[w].common_square_psi += common * common;
    }
  }

  std::vector<WindowErrors> take() {
    for (WindowErrors& window : windows_) {
      for (std::size_t taxel = 0; taxel < window.mean_psi.size(); ++taxel) {
        const bool any = window.frames > 0.0 && fit_.taxels[taxel].fitted();
        window.mean_psi[taxel] = any ? window.mean_psi[taxel] / window.frames : kNan;
        window.square_psi[taxel] = any ? window.square_psi[taxel] / window.frames : kNan;
      }
      window.common_square_psi = window.frames > 0.0 ? window.common_square_psi / window.frames : kNan;
    }
    return std::move(windows_);
  }

 private:
  [[nodiscard]] std::pair<std::size_t, std::size_t> windows_of(double setpoint_psi, bool up) const {
    constexpr double kOnTheEdge = 1e-6;
    const std::vector<double>& grid = fit_.pressure_psi;
    const auto low = std::ranges::lower_bound(grid, setpoint_psi - kHistoryWindowPsi - kOnTheEdge);
    const auto high = std::ranges::upper_bound(grid, setpoint_psi + kHistoryWindowPsi + kOnTheEdge);
    const std::size_t offset = up ? 0 : grid.size();
    return {offset + static_cast<std::size_t>(low - grid.begin()),
            offset + static_cast<std::size_t>(high - grid.begin())};
  }
  const SensorModel& fit_;
  const LevelCorrections& corrections_;
  std::vector<WindowErrors> windows_;
};

}  // namespace

double correction_at(const LevelCorrections& corrections, const SensorModel& fit, std::size_t taxel,
                     double pressure_psi, bool up) {
  if (corrections.empty()) return 0.0;
  const std::vector<double>& grid = fit.pressure_psi;
  const auto value = [&](std::size_t level) {
    const double own = corrections[((up ? 0 : grid.size()) + level) * fit.array().size() + taxel];
    return std::isnan(own) ? 0.0 : own;
  };
  const auto above = static_cast<std::size_t>(std::ranges::lower_bound(grid, pressure_psi) - grid.begin());
  if (above == 0 || std::isnan(pressure_psi)) return value(0);
  if (above == grid.size()) return value(grid.size() - 1);
  const double share = (pressure_psi - grid[above - 1]) / (grid[above] - grid[above - 1]);
  return std::lerp(value(above - 1), value(above), share);
}

HistoryErrors history_errors(std::span<const Dataset* const> runs, const SensorModel& fit, BranchesOf which,
                             const LevelCorrections& corrections, int threads) {
  HistoryErrors errors;
  WindowSums sums(fit, corrections);
  std::vector<double> held;
  for (const Dataset* run : runs) {
    errors.runs.push_back(run->run);
    sums.add(*run, which, threads);
    for (const SequenceData& sequence : run->sequences)
      for (const Repeat& repeat : sequence.repeats)
        for (const Sample& sample : repeat.steps) held.push_back(sample.held_s);
  }
  errors.windows = sums.take();
  if (held.empty()) return errors;
  errors.dwell_low_s = quantile_of(held, 0.05);
  errors.dwell_high_s = quantile_of(held, 0.95);
  return errors;
}

}  // namespace tactbench::analysis
