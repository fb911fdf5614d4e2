#include "analysis/statistics/figures/reading_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/moments.h"

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

namespace {

constexpr double kZeroShare = 0.01;  // of the range: a repeat this near to the lowest level begins or ends there

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
  const std::size_t width = fit.array().size();
  const std::vector<double>& grid = fit.pressure_psi;
  SweepErrors errors;
  for (const bool up : {true, false})
    for (const double pressure : grid) errors.levels.push_back({pressure, up, 0, {}, {}});
  const FrameErrors of_run = frame_errors(dataset, fit, threads);
  std::map<std::pair<std::size_t, int>, int> groups;  // by sequence and branch
  for (std::size_t i = 0; i < of_run.frames.size(); ++i) {
    const FrameErrors::Frame& frame = of_run.frames[i];
    const auto at = std::ranges::lower_bound(grid, frame.setpoint_psi - kSameLevelPsi);
    if (!frame.full || at == grid.end() || !same_level(*at, frame.setpoint_psi)) continue;
    LevelReadings& level = errors.levels[static_cast<std::size_t>(at - grid.begin()) + (frame.up ? 0 : grid.size())];
    ++level.readings;
    level.group.push_back(
        groups.try_emplace({frame.sequence, frame.branch}, static_cast<int>(groups.size())).first->second);
    const double* const row = &of_run.error_psi[i * width];
    level.error_psi.insert(level.error_psi.end(), row, row + width);
  }
  errors.groups = static_cast<int>(groups.size());
  measure_zero_return(dataset, grid.front(), kZeroShare * (grid.back() - grid.front()), errors);
  return errors;
}

std::vector<double> mean_errors(const SweepErrors& errors, std::size_t taxels) {
  std::vector<double> means;
  for (const LevelReadings& level : errors.levels)
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      std::vector<double> own;
      for (std::size_t i = 0; i < level.readings; ++i) own.push_back(level.error_psi[i * taxels + taxel]);
      means.push_back(mean_of(own));
    }
  return means;
}

namespace {

constexpr double kSweepEndShare = 0.01;  // a sweep is full when its ends are this near to the models' range

struct FullSweep {
  std::size_t first;  // of its frames, as frame_errors() counts them
  std::vector<double> setpoint_psi;
};

// Loading sweeps with the levels of the first.
std::vector<FullSweep> full_sweeps(const Dataset& dataset, double low, double high) {
  const double end = kSweepEndShare * (high - low);
  std::vector<FullSweep> sweeps;
  std::size_t frame = 0;
  for (const SequenceData& sequence : dataset.sequences)
    for (const Repeat& repeat : sequence.repeats) {
      std::vector<double> x;
      for (const Sample& step : repeat.steps) x.push_back(step.setpoint_psi);
      for (const Branch& branch : branches_along(x)) {
        const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
        if (!branch.ascending || x[first] > low + end || x[last] < high - end) continue;
        FullSweep sweep{frame + first, {x.begin() + branch.first, x.begin() + branch.last + 1}};
        if (sweeps.empty() || sweep.setpoint_psi == sweeps.front().setpoint_psi) sweeps.push_back(std::move(sweep));
      }
      frame += x.size();
    }
  return sweeps;
}

}  // namespace

std::size_t SweepEstimates::level(double pressure) const {
  constexpr double kSamePsi = 0.05;
  const auto found =
      std::ranges::find_if(pressure_psi, [&](double level) { return std::abs(level - pressure) < kSamePsi; });
  return static_cast<std::size_t>(found - pressure_psi.begin());
}

double SweepEstimates::mean(std::size_t level, int taxel) const {
  double sum = 0.0;
  for (int sweep = 0; sweep < sweeps; ++sweep) sum += at(level, sweep, taxel);
  return sum / sweeps;
}

SweepEstimates sweep_estimates(const Dataset& measured, const SensorModel& fit, int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const std::vector<FullSweep> sweeps = full_sweeps(dataset, fit.pressure_psi.front(), fit.pressure_psi.back());
  if (sweeps.empty())
    throw AnalysisError("TB-ANALYSIS-NO-LOOP",
                        fmt::format("run {} has no full sweep from {}", dataset.run,
                                    both_units_span(fit.pressure_psi.front(), fit.pressure_psi.back())),
                        "compare runs of recipes with full loops: descending, ascending, production");
  const FrameErrors of_run = frame_errors(dataset, fit, threads);
  SweepEstimates out;
  out.pressure_psi = sweeps.front().setpoint_psi;
  out.sweeps = static_cast<int>(sweeps.size());
  out.taxels = dataset.taxels();
  const auto width = static_cast<std::size_t>(out.taxels);
  for (std::size_t level = 0; level < out.pressure_psi.size(); ++level)
    for (const FullSweep& sweep : sweeps)
      for (std::size_t taxel = 0; taxel < width; ++taxel)
        out.psi.push_back(of_run.frames[sweep.first + level].setpoint_psi +
                          of_run.error_psi[(sweep.first + level) * width + taxel]);
  return out;
}

}  // namespace tactbench::analysis
