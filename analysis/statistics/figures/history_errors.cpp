#include "analysis/statistics/figures/history_errors.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

// First and last but one of the levels within the window of a set-point.
std::pair<std::size_t, std::size_t> levels_about(const std::vector<double>& grid, double setpoint_psi) {
  const auto low = std::ranges::lower_bound(grid, setpoint_psi - kHistoryWindowPsi - kSameLevelPsi);
  const auto high = std::ranges::upper_bound(grid, setpoint_psi + kHistoryWindowPsi + kSameLevelPsi);
  return {static_cast<std::size_t>(low - grid.begin()), static_cast<std::size_t>(high - grid.begin())};
}

class WindowSums {
 public:
  WindowSums(const SensorModel& fit, const LevelCorrections& corrections)
      : fit_(fit), corrections_(corrections), width_(fit.array().size()) {
    for (const bool up : {true, false})
      for (const double pressure : fit.pressure_psi)
        windows_.push_back({pressure, up, 0.0, 0.0, std::vector<double>(width_, 0.0), 0.0});
  }

  void add(const FrameHistory& history) {
    std::set<std::tuple<std::size_t, std::size_t, int>> ways;  // window, sequence, branch
    std::vector<double> errors(width_);
    for (const std::size_t i : history.frames) {
      const FrameErrors::Frame& frame = history.run->frames[i];
      const auto [first, end] = levels_about(fit_.pressure_psi, frame.setpoint_psi);
      for (std::size_t taxel = 0; taxel < width_; ++taxel)
        errors[taxel] = history.run->error_psi[i * width_ + taxel] -
                        correction_at(corrections_, fit_, taxel, frame.setpoint_psi, frame.up);
      const double common = mean_of(finite_of(errors));
      for (std::size_t level = first; level < end; ++level) {
        const std::size_t at = level + (frame.up ? 0 : fit_.pressure_psi.size());
        WindowErrors& window = windows_[at];
        ways.insert({at, frame.sequence, frame.branch});
        window.frames += 1.0;
        window.common_square_psi += common * common;
        for (std::size_t taxel = 0; taxel < width_; ++taxel) window.square_psi[taxel] += errors[taxel] * errors[taxel];
      }
    }
    for (const auto& way : ways) windows_[std::get<0>(way)].branches += 1.0;
  }

  std::vector<WindowErrors> take() {
    for (WindowErrors& window : windows_) {
      for (std::size_t taxel = 0; taxel < width_; ++taxel)
        window.square_psi[taxel] =
            window.frames > 0.0 && fit_.taxels[taxel].fitted() ? window.square_psi[taxel] / window.frames : kNan;
      window.common_square_psi = window.frames > 0.0 ? window.common_square_psi / window.frames : kNan;
    }
    return std::move(windows_);
  }

 private:
  const SensorModel& fit_;
  const LevelCorrections& corrections_;
  std::size_t width_;
  std::vector<WindowErrors> windows_;
};

}  // namespace

bool has_any_branch(std::span<const WindowErrors> windows) {
  return std::ranges::any_of(windows, [](const WindowErrors& window) { return window.branches > 0.0; });
}

double correction_at(const LevelCorrections& corrections, const SensorModel& fit, std::size_t taxel,
                     double pressure_psi, bool up) {
  if (corrections.empty()) return 0.0;
  const std::vector<double>& grid = fit.pressure_psi;
  const auto value = [&](std::size_t level) {
    const double own = corrections[((up ? 0 : grid.size()) + level) * fit.array().size() + taxel];
    return std::isnan(own) ? 0.0 : own;
  };
  const Between at = place_among(grid, pressure_psi);
  return std::lerp(value(at.low), value(at.high), at.share);
}

FrameErrors frame_errors(const Dataset& run, const SensorModel& fit, int threads) {
  const std::size_t width = fit.array().size();
  FrameErrors out;
  out.run = run.run;
  std::vector<std::vector<std::size_t>> first;  // sequence, repeat: place of its first frame
  for (std::size_t s = 0; s < run.sequences.size(); ++s) {
    const SequenceData& sequence = run.sequences[s];
    const std::vector<StepKind> kinds = step_kinds(sequence, fit.pressure_psi.front(), fit.pressure_psi.back());
    first.emplace_back();
    for (std::size_t r = 0; r < sequence.repeats.size(); ++r) {
      first.back().push_back(out.frames.size());
      const std::vector<Sample>& steps = sequence.repeats[r].steps;
      for (std::size_t i = 0; i < steps.size(); ++i)
        out.frames.push_back(
            {steps[i].setpoint_psi, steps[i].reference_psi, kinds[i].full, kinds[i].up, s, r, i, kinds[i].branch});
    }
  }
  out.error_psi.assign(out.frames.size() * width, kNan);
  compensate_in_order(run, fit, threads, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      const std::size_t at = first[s][r] + i;
      out.error_psi[at * width + taxel] = now.pressure_psi - out.frames[at].reference_psi;
    };
  });
  return out;
}

std::vector<WindowErrors> pooled_errors(std::span<const FrameHistory> histories, const SensorModel& fit,
                                        const LevelCorrections& corrections, std::optional<std::size_t> all_but) {
  WindowSums sums(fit, corrections);
  for (std::size_t i = 0; i < histories.size(); ++i)
    if (i != all_but) sums.add(histories[i]);
  return sums.take();
}

}  // namespace tactbench::analysis
