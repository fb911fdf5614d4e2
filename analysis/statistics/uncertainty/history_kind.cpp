#include "analysis/statistics/uncertainty/history_kind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
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
