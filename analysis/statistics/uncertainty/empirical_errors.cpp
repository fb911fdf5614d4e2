#include "analysis/statistics/uncertainty/empirical_errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "analysis/counted.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
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
    std::string text =
        fmt::format("{} of {}, {} readings of each taxel", counted(out.histories, "history", "histories"),
                    counted(evidence.runs.size(), "run"), out.readings);
    if (static_cast<std::size_t>(out.condition) >= kHistoryKinds) {
      std::vector<std::string> kinds;
      for (const UseCondition kind : evidence.kinds) kinds.emplace_back(name_of(kind));
      text += fmt::format(": {}", fmt::join(kinds, "; "));
    }
    if (evidence.arrival_high_s > 0.0)
      text += fmt::format("; levels read {:.1f} to {:.1f} s after the command", evidence.arrival_low_s,
                          evidence.arrival_high_s);
    return text;
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

namespace {

constexpr double kEndShare = 0.01;  // of the range: this near to an end is at it, as step_kinds

// Steps at a level above `above` that is held.
std::vector<bool> held_steps(const std::vector<Sample>& steps, double above) {
  std::vector<bool> held(steps.size(), false);
  for (std::size_t first = 0, end = 0; first < steps.size(); first = end) {
    for (end = first; end < steps.size() && same_level(steps[end].setpoint_psi, steps[first].setpoint_psi);) ++end;
    if (steps[first].setpoint_psi > above && end - first >= 2 &&
        steps[end - 1].held_s - steps[first].held_s >= kMinHeldS)
      std::fill(held.begin() + static_cast<std::ptrdiff_t>(first), held.begin() + static_cast<std::ptrdiff_t>(end),
                true);
  }
  return held;
}

// How the inner branches of a sequence go.
std::optional<UseCondition> inner_kind(const std::vector<Sample>& steps, const std::vector<StepKind>& kinds,
                                       double range) {
  std::vector<double> lengths, turns;
  bool inner_before = false;
  double from = steps.front().setpoint_psi;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i + 1 < steps.size() && kinds[i + 1].branch == kinds[i].branch) continue;
    const double to = steps[i].setpoint_psi;  // the last step of its branch
    if (!kinds[i].full) {
      lengths.push_back(std::abs(to - from));
      if (inner_before) turns.push_back(from);
    }
    inner_before = !kinds[i].full;
    from = to;
  }
  if (lengths.size() >= kMinSmallReversals && median_of(lengths) <= kSmallShare * range)
    return UseCondition::kSmallReversals;
  if (turns.empty()) return {};
  const auto [least, most] = std::ranges::minmax(turns);
  return most - least >= kWholeShare * range ? std::optional(UseCondition::kReversals) : std::nullopt;
}

bool goes_as(const SequenceData& one, const SequenceData& other) {
  return std::ranges::equal(
      one.repeats.front().steps, other.repeats.front().steps,
      [](const Sample& a, const Sample& b) { return same_level(a.setpoint_psi, b.setpoint_psi); });
}

// Of the frames of one repeat or of a whole run that are the first at their level.
std::vector<double> arrivals_of(const std::vector<Sample>& steps) {
  std::vector<double> times;
  const auto lowest = std::ranges::min_element(steps, {}, &Sample::setpoint_psi);
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (!same_level(steps[i].setpoint_psi, lowest->setpoint_psi) && steps[i].held_s > 0.0 &&
        (i == 0 || !same_level(steps[i].setpoint_psi, steps[i - 1].setpoint_psi)))
      times.push_back(steps[i].held_s);
  return times;
}

}  // namespace

std::vector<std::optional<UseCondition>> history_kinds(const SequenceData& sequence, double low, double high,
                                                       bool pressed) {
  const std::vector<Sample>& steps = sequence.repeats.front().steps;
  const double range = high - low, near = kEndShare * range;
  std::vector<std::optional<UseCondition>> out(steps.size());
  const std::vector<bool> held = held_steps(steps, low + near);
  if (std::ranges::find(held, true) != held.end()) {
    for (std::size_t i = 0; i < steps.size(); ++i)
      if (held[i]) out[i] = UseCondition::kHeld;
    return out;
  }
  const std::vector<StepKind> kinds = step_kinds(sequence, low, high);
  const std::optional<UseCondition> inner = inner_kind(steps, kinds, range);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    pressed = pressed || steps[i].setpoint_psi >= high - near;
    if (kinds[i].full)
      out[i] = UseCondition::kFullSweeps;
    else if (pressed)
      out[i] = inner;
  }
  return out;
}

std::vector<KindHistories> kind_histories(const Dataset& run, const FrameErrors& errors, const Dataset& calibration,
                                          double low, double high) {
  std::vector<KindHistories> out;
  bool pressed = false;
  double before_s = -1.0;
  std::size_t at = 0;
  for (const SequenceData& sequence : run.sequences) {
    const bool fitted =
        std::ranges::any_of(calibration.sequences, [&](const SequenceData& other) { return goes_as(sequence, other); });
    std::vector<KindHistories> own;  // of this sequence, so far
    for (const Repeat& repeat : sequence.repeats) {
      pressed = pressed || time_passed(repeat.steps.front(), before_s).worked_s > 0.0;
      before_s = repeat.steps.back().time_s;
      const std::vector<std::optional<UseCondition>> kinds = history_kinds(sequence, low, high, pressed);
      const double arrival_s = [&] {
        const std::vector<double> times = arrivals_of(repeat.steps);
        return times.empty() ? 0.0 : median_of(times);
      }();
      bool swept = false;
      for (std::size_t i = 0; i < kinds.size(); ++i, ++at) {
        pressed = pressed || repeat.steps[i].setpoint_psi >= high - kEndShare * (high - low);
        if (!kinds[i] || (fitted && *kinds[i] != UseCondition::kFullSweeps)) continue;
        const bool sweep = *kinds[i] == UseCondition::kFullSweeps;
        auto found = std::ranges::find(own, *kinds[i], &KindHistories::kind);
        if (sweep && !swept && found != own.end()) {
          out.push_back(std::move(*found));
          own.erase(found);
          found = own.end();
        }
        swept = swept || sweep;
        if (found == own.end()) found = own.insert(own.end(), {*kinds[i], {&errors, {}}, arrival_s, 0.0});
        found->history.frames.push_back(at);
        found->held_s = std::max(found->held_s, repeat.steps[i].held_s);
      }
    }
    std::ranges::move(own, std::back_inserter(out));
  }
  return out;
}

std::array<std::size_t, kHistoryKinds> planned_histories(const std::vector<SequenceData>& judged,
                                                         const std::vector<SequenceData>& calibration) {
  std::array<std::size_t, kHistoryKinds> histories{};
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const SequenceData& sequence : calibration.empty() ? judged : calibration)
    for (const Sample& step : sequence.repeats.front().steps) {
      low = std::min(low, step.setpoint_psi);
      high = std::max(high, step.setpoint_psi);
    }
  for (const SequenceData& sequence : judged) {
    const bool fitted =
        std::ranges::any_of(calibration, [&](const SequenceData& other) { return goes_as(sequence, other); });
    const std::vector<std::optional<UseCondition>> kinds = history_kinds(sequence, low, high, true);
    for (std::size_t kind = 0; kind < kHistoryKinds; ++kind) {
      const bool sweeps = static_cast<UseCondition>(kind) == UseCondition::kFullSweeps;
      if (std::ranges::find(kinds, static_cast<UseCondition>(kind)) == kinds.end() || (fitted && !sweeps)) continue;
      histories[kind] += sweeps ? sequence.repeats.size() : 1;
    }
  }
  return histories;
}

std::optional<ArrivalTimes> arrival_times(const Dataset& run) {
  std::vector<double> times;
  for (const SequenceData& sequence : run.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (const double time : arrivals_of(repeat.steps)) times.push_back(time);
  if (times.empty()) return {};
  return ArrivalTimes{quantile_of(times, 0.05), quantile_of(times, 0.95)};
}

const char* name_of(UseCondition condition) {
  static constexpr std::array<const char*, kUseConditions> kNames = {
      "full sweeps",
      "reversals over the whole range after full pressure",
      "small reversals after full pressure",
      "held pressures",
      "at another dwell",
      "at another temperature",
      "mounted anew",
      "on another day"};
  return kNames[static_cast<std::size_t>(condition)];
}

ReadingUncertainty reading_uncertainty(const ConditionUncertainty& condition, std::size_t taxel, double reading_psi,
                                       bool up) {
  const auto rising = static_cast<std::size_t>(std::ranges::count(condition.up, true));
  const std::span<const double> levels = condition.pressure_psi;
  const std::span<const double> own = up ? levels.first(rising) : levels.subspan(rising);
  if (own.empty() || std::isnan(reading_psi)) return {kNan, kNan};
  const Between at = place_among(own, reading_psi);
  const std::size_t first = up ? 0 : rising, width = condition.taxels();
  const auto between = [&](const std::vector<double>& values) {
    return std::lerp(values[(first + at.low) * width + taxel], values[(first + at.high) * width + taxel], at.share);
  };
  return {between(condition.error_psi), between(condition.expanded_psi)};
}

std::optional<UseCondition> worst_of(std::span<const ConditionUncertainty> conditions) {
  const ConditionUncertainty* worst = nullptr;
  for (const ConditionUncertainty& each : conditions)
    if (each.valid() && static_cast<std::size_t>(each.condition) < kHistoryKinds &&
        (worst == nullptr || each.median_psi > worst->median_psi))
      worst = &each;
  return worst == nullptr ? std::nullopt : std::optional(worst->condition);
}

MeasuringInterval measuring_interval(const ConditionUncertainty& condition, bool up, double mpe_psi,
                                     std::span<const std::size_t> fitted, double share) {
  MeasuringInterval longest, now;
  for (std::size_t level = 0; level < condition.pressure_psi.size(); ++level) {
    if (condition.up[level] != up) continue;
    std::size_t within = 0;
    for (const std::size_t taxel : fitted) {
      const std::size_t at = level * condition.taxels() + taxel;
      within += std::abs(condition.error_psi[at]) + condition.expanded_psi[at] <= mpe_psi ? 1 : 0;
    }
    if (within == 0 || static_cast<double>(within) < share * static_cast<double>(fitted.size()) - 1e-9) {
      now = {};
      continue;
    }
    if (!now.any) now = {true, condition.pressure_psi[level], condition.pressure_psi[level]};
    now.high_psi = condition.pressure_psi[level];
    if (!longest.any || now.high_psi - now.low_psi > longest.high_psi - longest.low_psi) longest = now;
  }
  return longest;
}

}  // namespace tactbench::analysis
