#include "analysis/statistics/uncertainty/empirical_errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/counted.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kLikeDwell = 2.0;        // arrivals within this factor of the calibration's are like them
constexpr std::size_t kMostTaxels = 256;  // evenly taken: a quantile of thousands of errors needs no more
constexpr double kWaysOfShape = 8.0;      // the shape that all kinds share counts as so many ways through a window
constexpr double kDofOfAll = 4.0;         // the scatter of all kinds' histories counts as so many of the kind's own
// As a logarithm, one standard deviation: with normal errors U that is as much too small or too large holds 90 or 99 %.
constexpr double kMostOpen = 0.20;
constexpr double kUpperQuartile =
    0.674;  // of the normal distribution: three of four such sets of histories need no more

using Windows = std::vector<WindowErrors>;

std::vector<std::size_t> some_of(const std::vector<std::size_t>& fitted) {
  std::vector<std::size_t> chosen;
  const std::size_t count = std::min(kMostTaxels, fitted.size());
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(fitted[i * fitted.size() / count]);
  return chosen;
}

// Of the same direction, the nearest with frames, of two as near the lower; null: none.
const WindowErrors* nearest(const Windows& windows, const WindowErrors& to) {
  const WindowErrors* found = nullptr;
  for (const WindowErrors& window : windows)
    if (window.up == to.up && window.branches > 0.0 &&
        (found == nullptr ||
         std::abs(window.pressure_psi - to.pressure_psi) < std::abs(found->pressure_psi - to.pressure_psi)))
      found = &window;
  return found;
}

// What the kinds have in common: by level and direction each taxel's mean square, the mean over the kinds.
std::vector<std::vector<double>> shape_of(std::span<const Windows* const> kinds, std::size_t width) {
  std::vector<std::vector<double>> shape(kinds.front()->size(), std::vector<double>(width, kNan));
  for (std::size_t at = 0; at < shape.size(); ++at) {
    std::vector<const WindowErrors*> own;
    for (const Windows* windows : kinds)
      if (const WindowErrors* const found = nearest(*windows, (*windows)[at])) own.push_back(found);
    if (own.empty()) continue;
    for (std::size_t taxel = 0; taxel < width; ++taxel) {
      double sum = 0.0;
      for (const WindowErrors* window : own) sum += window->square_psi[taxel];
      shape[at][taxel] = sum / static_cast<double>(own.size());
    }
  }
  return shape;
}

// Of one kind: what was counted through a window, beside the common shape in the kind's own size. Few ways tell little
// of one taxel at one level, and all together much of how large the kind's errors are (H.3.6). Taxels by window; NaN
// where no way of the kind goes in that direction.
std::vector<std::vector<double>> mean_squares(const Windows& windows, std::span<const Windows* const> kinds,
                                              const std::vector<std::size_t>& fitted, std::size_t width) {
  std::vector<std::vector<double>> squares = shape_of(kinds, width);
  double sum = 0.0, ways = 0.0;
  for (std::size_t at = 0; at < windows.size(); ++at) {
    if (!(windows[at].branches > 0.0)) continue;
    std::vector<double> ratios;  // the median: a few taxels with a flat curve would have the mean to themselves
    for (const std::size_t taxel : fitted)
      if (squares[at][taxel] > 0.0) ratios.push_back(windows[at].square_psi[taxel] / squares[at][taxel]);
    if (ratios.empty()) continue;
    sum += windows[at].branches * median_of(std::move(ratios));
    ways += windows[at].branches;
  }
  const double size = ways > 0.0 ? sum / ways : 1.0;
  for (std::size_t at = 0; at < windows.size(); ++at) {
    const bool gone = nearest(windows, windows[at]) != nullptr;
    const double own = windows[at].branches;
    for (double& square : squares[at]) square = gone ? kWaysOfShape * size * square / (own + kWaysOfShape) : kNan;
    if (own > 0.0)
      for (const std::size_t taxel : fitted)
        squares[at][taxel] += own * windows[at].square_psi[taxel] / (own + kWaysOfShape);
  }
  return squares;
}

// Of what histories of one kind need, as a logarithm: squares about their mean.
struct Scatter {
  double squares = 0.0, dof = 0.0;
  void add(const std::vector<double>& needed) {
    if (needed.size() < kLeastHistories) return;
    std::vector<double> logarithms;
    for (const double each : needed) logarithms.push_back(std::log(each));
    const auto count = static_cast<double>(needed.size());
    // Each is held against the others, whose mean lies on the other side of that of all.
    squares += std::pow((count - 1.0) / count, 2) * sum_of_squares_about(logarithms, mean_of(logarithms));
    dof += count - 1.0;
  }
};

class Counting {
 public:
  Counting(const EmpiricalErrors& counted, const SensorModel& fit, const LevelCorrections& corrections,
           std::span<const LevelReadings> levels, const std::function<double(double)>& unobservable_u_psi)
      : counted_(counted),
        fit_(fit),
        corrections_(corrections),
        hidden_psi_(unobservable_u_psi),
        width_(fit.array().size()),
        fitted_(fit.fitted()) {
    for (std::size_t at = 0; at < levels.size(); ++at)
      if (levels[at].readings > 0) {
        levels_.push_back(at);
        empty_.pressure_psi.push_back(levels[at].pressure_psi);
        empty_.up.push_back(levels[at].up);
        for (std::size_t taxel = 0; taxel < width_; ++taxel)
          empty_.error_psi.push_back(corrections[at * width_ + taxel]);
      }
    for (std::size_t which = 0; which < kUseConditions; ++which)
      windows_[which] = pooled_errors(counted.made_in[which].histories, fit, corrections);
  }

  std::vector<ConditionUncertainty> all() {
    std::array<Needed, kUseConditions> needed;
    Scatter scatter;
    for (std::size_t which = 0; which < kUseConditions; ++which) {
      needed[which] = needed_of(which);
      scatter.add(needed[which].each);
    }
    std::vector<ConditionUncertainty> out;
    for (std::size_t which = 0; which < kUseConditions; ++which) out.push_back(of(which, needed[which], scatter));
    return out;
  }

 private:
  // What root mean squares of the others have to be multiplied by to hold 95.45 % of each history, and of all.
  struct Needed {
    std::vector<double> each;
    double all = kNan;
  };

  // Kinds whose errors have their shape in common with those of `which`, whose own are `own`.
  [[nodiscard]] std::vector<std::vector<double>> squares_of(std::size_t which, const Windows& own) const {
    std::vector<const Windows*> kinds = {&own};
    for (std::size_t kind = 0; kind < kHistoryKinds; ++kind)
      if (kind != which && has_any_branch(windows_[kind])) kinds.push_back(&windows_[kind]);
    return mean_squares(own, kinds, fitted_, width_);
  }

  [[nodiscard]] ConditionUncertainty stated(std::vector<std::vector<double>> squares, double factor,
                                            bool hidden) const {
    ConditionUncertainty out = empty_;
    for (const std::size_t at : levels_) {
      const double u = hidden ? hidden_psi_(fit_.pressure_psi[at % fit_.pressure_psi.size()]) : 0.0;
      for (const double square : squares[at])
        out.expanded_psi.push_back(std::hypot(coverage_factor(kInfiniteDof) * u, factor * std::sqrt(square)));
    }
    return out;
  }

  Needed needed_of(std::size_t which) const {
    const std::vector<FrameHistory>& histories = counted_.made_in[which].histories;
    Needed out;
    if (histories.size() < kLeastHistories) return out;
    const std::vector<std::size_t> taxels = some_of(fitted_);
    std::vector<double> all;
    for (std::size_t history = 0; history < histories.size(); ++history) {
      const Windows others = pooled_errors(histories, fit_, corrections_, history);
      const ConditionUncertainty of_others = stated(squares_of(which, others), 1.0, false);
      std::vector<double> ratios;
      for (const std::size_t i : histories[history].frames) {
        const FrameErrors::Frame& frame = histories[history].run->frames[i];
        for (const std::size_t taxel : taxels) {
          const double error = histories[history].run->error_psi[i * width_ + taxel];
          const auto [known, u] = reading_uncertainty(of_others, taxel, frame.reference_psi + error, frame.up);
          if (const double ratio = std::abs(error - known) / u; std::isfinite(ratio)) ratios.push_back(ratio);
        }
      }
      if (ratios.empty()) continue;
      all.insert(all.end(), ratios.begin(), ratios.end());
      out.each.push_back(quantile_of(std::move(ratios), kCoverageProbability));
    }
    if (!all.empty()) out.all = quantile_of(std::move(all), kCoverageProbability);
    std::erase_if(out.each, [](double needed) { return !(needed > 0.0); });
    return out;
  }

  // What the histories of a kind leave open of k: the standard deviation of its logarithm. That of their own, beside
  // which those of all kinds count, because a few tell little of how much they differ.
  [[nodiscard]] static double open_of(const Needed& needed, const Scatter& of_all) {
    if (!(of_all.dof > 0.0) || needed.each.empty()) return 0.0;
    Scatter own{kDofOfAll * of_all.squares / of_all.dof, kDofOfAll};
    own.add(needed.each);
    return std::sqrt(own.squares / own.dof / static_cast<double>(needed.each.size()));
  }

  [[nodiscard]] std::string why_not(const EmpiricalEvidence& evidence, const Needed& needed, double open) const {
    const std::size_t count = evidence.histories.size();
    if (count == 0) return "no held-out history of this kind was measured";
    if (count < kLeastHistories) return "one history alone cannot check U: measure a second one";
    if (empty_.pressure_psi.empty()) return "no level with full sweeps of the calibration";
    if (!std::isfinite(needed.all)) return "no error of these histories lies at a level with U";
    if (open <= kMostOpen) return {};
    return fmt::format("{} leave U open by {:.0f} %: measure {:.0f} or more", counted(count, "history", "histories"),
                       100.0 * open, std::ceil(static_cast<double>(count) * std::pow(open / kMostOpen, 2)));
  }

  ConditionUncertainty of(std::size_t which, const Needed& needed, const Scatter& scatter) const {
    const EmpiricalEvidence& evidence = counted_.made_in[which];
    ConditionUncertainty out;
    const double open = open_of(needed, scatter), factor = needed.all * std::exp(kUpperQuartile * open);
    const std::string why = why_not(evidence, needed, open);
    if (why.empty()) out = stated(squares_of(which, windows_[which]), factor, true);
    out.condition = static_cast<UseCondition>(which);
    out.name = name_of(out.condition);
    if (evidence.held_s > 0.0 && out.condition == UseCondition::kHeld)
      out.name += fmt::format(" (up to {:.0f} s)", evidence.held_s);
    out.not_valid = why;
    out.runs = evidence.runs;
    out.histories = evidence.histories.size();
    for (const FrameHistory& history : evidence.histories) out.readings += history.frames.size();
    if (out.histories > 0) out.basis = basis(evidence, out);
    if (!out.valid()) return out;
    out.factor = factor;
    out.median_psi = median_of(out.expanded_psi);
    if (!std::isnan(out.median_psi)) return out;
    out.not_valid = "U of the reference is not known at the levels of the calibration";
    out.pressure_psi.clear();
    out.up.clear();
    out.expanded_psi.clear();
    out.error_psi.clear();
    return out;
  }

  [[nodiscard]] static std::string basis(const EmpiricalEvidence& evidence, const ConditionUncertainty& out) {
    std::string words =
        fmt::format("{} of {}, {} readings of each taxel", counted(out.histories, "history", "histories"),
                    counted(evidence.runs.size(), "run"), out.readings);
    if (static_cast<std::size_t>(out.condition) >= kHistoryKinds) {
      std::vector<std::string> kinds;
      for (const UseCondition kind : evidence.kinds) kinds.emplace_back(name_of(kind));
      words += fmt::format(": {}", fmt::join(kinds, "; "));
    }
    if (evidence.arrival_high_s > 0.0)
      words += fmt::format("; levels read {:.1f} to {:.1f} s after the command", evidence.arrival_low_s,
                           evidence.arrival_high_s);
    return words;
  }

  const EmpiricalErrors& counted_;
  const SensorModel& fit_;
  const LevelCorrections& corrections_;
  const std::function<double(double)>& hidden_psi_;
  std::size_t width_;
  std::vector<std::size_t> fitted_, levels_;  // levels: with readings
  ConditionUncertainty empty_;                // their pressures and known errors
  std::array<Windows, kUseConditions> windows_;
};

void add(EmpiricalEvidence& evidence, KindHistories one, bool of_same_unit) {
  if (of_same_unit && !evidence.histories.empty() && evidence.histories.back().run == one.history.run) {
    std::vector<std::size_t>& frames = evidence.histories.back().frames;
    frames.insert(frames.end(), one.history.frames.begin(), one.history.frames.end());
  } else {
    evidence.histories.push_back(one.history);
  }
  if (std::ranges::find(evidence.kinds, one.kind) == evidence.kinds.end()) evidence.kinds.push_back(one.kind);
  if (evidence.runs.empty() || evidence.runs.back() != one.history.run->run)
    evidence.runs.push_back(one.history.run->run);
  evidence.held_s = std::max(evidence.held_s, one.held_s);
  if (!(one.arrival_s > 0.0)) return;
  evidence.arrival_low_s =
      evidence.arrival_low_s > 0.0 ? std::min(evidence.arrival_low_s, one.arrival_s) : one.arrival_s;
  evidence.arrival_high_s = std::max(evidence.arrival_high_s, one.arrival_s);
}

}  // namespace

EmpiricalErrors empirical_errors(const Dataset& calibration, const HistoryRuns& history, const SensorModel& fit,
                                 int threads) {
  EmpiricalErrors out;
  const double low = fit.pressure_psi.front(), high = fit.pressure_psi.back();
  const std::optional<ArrivalTimes> usual = arrival_times(calibration);
  const std::array<std::pair<UseCondition, const std::vector<const Dataset*>*>, 4> given = {
      {{UseCondition::kFullSweeps, &history.same},
       {UseCondition::kOtherTemperature, &history.warm},
       {UseCondition::kRemounted, &history.mounted},
       {UseCondition::kLater, &history.later}}};
  std::size_t count = 0;
  for (const auto& [condition, runs] : given) count += runs->size();
  out.runs.reserve(count);  // histories point into it
  for (const auto& [condition, runs] : given)
    for (const Dataset* run : *runs) {
      const FrameErrors& errors = out.runs.emplace_back(frame_errors(*run, fit, threads));
      const bool same = condition == UseCondition::kFullSweeps;
      for (KindHistories& one : kind_histories(*run, errors, calibration, low, high)) {
        const bool like = one.kind == UseCondition::kHeld || !usual || !(one.arrival_s > 0.0) ||
                          (one.arrival_s >= usual->low_s / kLikeDwell && one.arrival_s <= usual->high_s * kLikeDwell);
        const UseCondition counts_for = !same ? condition : like ? one.kind : UseCondition::kOtherDwell;
        // Another dwell in another state is evidence for neither.
        if (same || like) add(out.made_in[static_cast<std::size_t>(counts_for)], std::move(one), !same);
      }
    }
  return out;
}

std::vector<ConditionUncertainty> empirical_uncertainty(const EmpiricalErrors& counted, const SensorModel& fit,
                                                        const LevelCorrections& corrections,
                                                        std::span<const LevelReadings> levels,
                                                        const std::function<double(double psi)>& unobservable_u_psi) {
  return Counting(counted, fit, corrections, levels, unobservable_u_psi).all();
}

}  // namespace tactbench::analysis
