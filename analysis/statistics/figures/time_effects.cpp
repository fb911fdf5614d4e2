#include "analysis/statistics/figures/time_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kEndFrames = 5;      // averaged at the end of a hold
constexpr double kHeldLongerThan = 2.0;    // times read_after_s: shorter holds add nothing to the dwell
constexpr double kHoldSlopeHalfPsi = 0.5;  // half of the pressures' distance that a slope is taken over

// Time from command to frame where a level is read once; NaN where no frame states it.
double usual_time(const Dataset& calibration) {
  std::vector<double> times;
  const std::vector<HeldFrames> holds = held_frames_of(calibration);
  for (std::size_t s = 0; s < calibration.sequences.size(); ++s) {
    if (std::ranges::any_of(holds, [&](const HeldFrames& hold) { return hold.sequence == s; })) continue;
    for (const Repeat& repeat : calibration.sequences[s].repeats)
      for (const Sample& step : repeat.steps)
        if (step.setpoint_psi > kHeldAbovePsi && step.held_s > 0.0) times.push_back(step.held_s);
  }
  return median_of(std::move(times));
}

// Output and reference at a time within a hold, or over its last frames.
struct HoldMoment {
  double volts = 0.0, reference_psi = 0.0;
};

class HoldReader {
 public:
  HoldReader(const Repeat& repeat, const HeldFrames& hold, std::size_t width)
      : repeat_(&repeat), hold_(&hold), width_(width) {}
  // Linear between two frames; before the first one the first. `time_s` at most that of the last one.
  [[nodiscard]] HoldMoment at(std::size_t taxel, double time_s) const {
    std::size_t after = hold_->first;
    while (after + 1 < hold_->end && hold_->held_s(*repeat_, after) < time_s) ++after;
    const HoldMoment high = frame(taxel, after);
    if (after == hold_->first) return high;
    const HoldMoment low = frame(taxel, after - 1);
    const double begin = hold_->held_s(*repeat_, after - 1), end = hold_->held_s(*repeat_, after);
    const double share = (time_s - begin) / (end - begin);
    return {std::lerp(low.volts, high.volts, share), std::lerp(low.reference_psi, high.reference_psi, share)};
  }
  [[nodiscard]] HoldMoment end(std::size_t taxel) const {
    HoldMoment mean;
    for (std::size_t i = hold_->end - kEndFrames; i < hold_->end; ++i) {
      mean.volts += frame(taxel, i).volts / static_cast<double>(kEndFrames);
      mean.reference_psi += frame(taxel, i).reference_psi / static_cast<double>(kEndFrames);
    }
    return mean;
  }

 private:
  [[nodiscard]] HoldMoment frame(std::size_t taxel, std::size_t step) const {
    return {repeat_->volts[step * width_ + taxel], repeat_->steps[step].reference_psi};
  }
  const Repeat* repeat_;
  const HeldFrames* hold_;
  std::size_t width_;
};

double slope_at(const ModelTaxel& model, bool up, double pressure) {
  const ExternalBranch curve(model, up);
  const double low = std::max(pressure - kHoldSlopeHalfPsi, model.x0());
  const double high = std::min(pressure + kHoldSlopeHalfPsi, model.xu());
  return (curve.output(high) - curve.output(low)) / (high - low);
}

HeldLevel level_of_hold(const Dataset& dataset, const HeldFrames& hold, const SensorModel& fit, double read_after_s) {
  const Repeat& repeat = dataset.sequences[hold.sequence].repeats[hold.repeat];
  const HoldReader reader(repeat, hold, static_cast<std::size_t>(dataset.taxels()));
  HeldLevel level{dataset.sequences[hold.sequence].name,
                  repeat.steps[hold.first].setpoint_psi,
                  hold.rose,
                  hold.held_s(repeat, hold.first),
                  hold.held_s(repeat, hold.end - 1),
                  std::vector<double>(fit.array().size(), kNan),
                  kNan};
  // A hold that begins late shows only part of the creep, which grows about with the logarithm of time.
  const double seen_from = std::max(level.from_s, read_after_s);
  const double whole = std::log(level.to_s / read_after_s) / std::log(level.to_s / seen_from);
  const Fitted fitted(fit);
  for (const std::size_t taxel : fitted.taxels()) {
    const ModelTaxel& model = fit.taxels[taxel];
    const HoldMoment begin = reader.at(taxel, seen_from), end = reader.end(taxel);
    const double explained = slope_at(model, hold.rose, level.pressure_psi) * (end.reference_psi - begin.reference_psi);
    const double over_zero = begin.volts - model.y0();
    if (over_zero > 0.0) level.share[taxel] = whole * std::abs(end.volts - begin.volts - explained) / over_zero;
  }
  level.median_share = median_of(level.share);
  return level;
}

// As the model's stream reads it.
Dataset with_fit_run_creep_removed(Dataset run, const SensorModel& fit) {
  ArrayDynamics own{fit.dynamics->shared, {}, {}};
  own.shared.lag_share = 0.0;
  std::vector<double> zero_v;
  for (const ModelTaxel& taxel : fit.array()) {
    own.creep_scale.push_back(taxel.creep_scale);
    own.lag_share.push_back(0.0);
    zero_v.push_back(taxel.fitted() ? taxel.y0() : 0.0);
  }
  return dataset_without_dynamics(std::move(run), own, zero_v, fit.pressure_psi.back());
}

void keep_larger(HeldLevel& kept, const HeldLevel& other) {
  for (std::size_t taxel = 0; taxel < kept.share.size(); ++taxel)
    kept.share[taxel] = std::fmax(kept.share[taxel], other.share[taxel]);
  kept.from_s = std::max(kept.from_s, other.from_s);
  kept.to_s = std::min(kept.to_s, other.to_s);
  kept.median_share = median_of(kept.share);
}

}  // namespace

double CreepEffect::share(std::size_t taxel, double pressure_psi, bool up) const {
  const bool own = std::ranges::any_of(levels, [up](const HeldLevel& level) { return level.up == up; });
  std::vector<double> pressures, shares;
  for (const HeldLevel& level : levels) {
    if ((own && level.up != up) || !std::isfinite(level.share[taxel])) continue;
    pressures.push_back(level.pressure_psi);
    shares.push_back(level.share[taxel]);
  }
  if (shares.empty()) return 0.0;
  const Between at = place_among(pressures, pressure_psi);
  return std::lerp(shares[at.low], shares[at.high], at.share);
}

std::string CreepEffect::display_text() const {
  if (!assessed()) return {};
  std::string held;
  for (const HeldLevel& level : levels)
    held += fmt::format("{}{} {} for {:.0f} s: {:.2f} %", held.empty() ? "" : ", ", both_units(level.pressure_psi, 1),
                        level.up ? "loading" : "unloading", level.to_s, 100.0 * level.median_share);
  const bool both = levels.front().up != levels.back().up;
  return fmt::format(
      "change of the median taxel's output over its zero in holds of {}{} ({}). Assumed: a reading is taken at any "
      "time "
      "from {:.1f} s, after which this run reads its levels, to {:.0f} s after the level was commanded, on a way to "
      "the "
      "level like that of the holds, and half of the whole change is taken off; what is read earlier or later is not "
      "covered. Each "
      "taxel counts with its own change; levels that were not held take the same share of the output over the zero{}{}",
      levels.front().sequence, undone ? ", beyond the creep that the models undo" : "", held, read_after_s, to_s,
      both ? "" : ", and so does the other branch, which was not held (creep-levels holds both)",
      extrapolated_back ? ". The holds' first frame is later than the dwell: extended on the logarithm of time" : "");
}

CreepEffect creep_effect_of(const Dataset& calibration, std::span<const Dataset> runs, const SensorModel& fit) {
  CreepEffect effect;
  effect.undone = fit.dynamics && compensates_creep(*fit.dynamics);
  if (effect.undone && fit.dynamics->creep.run != 0) {
    for (const Dataset& run : runs) check_same_sensor(run, fit);
    effect.not_assessed = "the model undoes creep; what it leaves of it is in the errors of held-out runs";
    return effect;
  }
  effect.read_after_s = usual_time(calibration);
  bool few = false, brief = false;
  for (const Dataset& run : runs) {
    check_same_sensor(run, fit);
    Dataset dataset = as_modelled(run, fit);
    if (effect.undone) dataset = with_fit_run_creep_removed(std::move(dataset), fit);
    few = few || !held_frames_of(dataset, 3).empty();
    for (const HeldFrames& hold : held_frames_of(dataset)) {
      const Repeat& repeat = dataset.sequences[hold.sequence].repeats[hold.repeat];
      const double pressure = repeat.steps[hold.first].setpoint_psi;
      if (pressure > fit.pressure_psi.back() + kSameLevelPsi || !(effect.read_after_s > 0.0)) continue;
      if (hold.held_s(repeat, hold.end - 1) < kHeldLongerThan * effect.read_after_s ||
          hold.held_s(repeat, hold.first) > hold.held_s(repeat, hold.end - 1) / kHeldLongerThan) {
        brief = true;
        continue;
      }
      const HeldLevel level = level_of_hold(dataset, hold, fit, effect.read_after_s);
      if (!std::isfinite(level.median_share)) continue;
      const auto same = std::ranges::find_if(effect.levels, [&](const HeldLevel& other) {
        return other.up == level.up && same_level(other.pressure_psi, level.pressure_psi);
      });
      if (same == effect.levels.end()) {
        effect.levels.push_back(level);
      } else {
        keep_larger(*same, level);
      }
    }
  }
  std::ranges::stable_sort(effect.levels, {},
                           [](const HeldLevel& level) { return std::pair(level.up ? 0 : 1, level.pressure_psi); });
  if (!effect.levels.empty()) {
    effect.to_s = std::ranges::min_element(effect.levels, {}, &HeldLevel::to_s)->to_s;
    effect.extrapolated_back =
        std::ranges::max_element(effect.levels, {}, &HeldLevel::from_s)->from_s > effect.read_after_s;
    effect.not_assessed.clear();
  } else if (few && !(effect.read_after_s > 0.0)) {
    effect.not_assessed = "this run does not record how long its levels were held before a frame";
  } else if (brief) {
    effect.not_assessed = fmt::format(
        "the holds given end before twice the {:.1f} s after which this run reads its "
        "levels, or begin too late: a run of creep-hold with more frames would show it",
        effect.read_after_s);
  } else if (few) {
    effect.not_assessed =
        fmt::format("the holds given have fewer than {} frames: a run of creep-hold would show it", kMinHeldFrames);
  }
  return effect;
}

// Creep at held levels: the slope of the output over the logarithm of time.

namespace {

Creep line_through(const std::vector<double>& held_s, const std::vector<double>& output_v) {
  std::vector<double> decades;
  for (const double time : held_s) decades.push_back(std::log10(time));
  const LineFit line = line_fit(decades, output_v);
  const double rest = residual_sum_of_squares(line, decades, output_v);
  Creep creep;
  creep.from_s = held_s.front();
  creep.to_s = held_s.back();
  creep.first_v = output_v.front();
  creep.last_v = output_v.back();
  creep.per_decade = line.slope() / creep.first_v;
  creep.per_decade_u = std::sqrt(rest / (static_cast<double>(held_s.size()) - 2.0) / line.xx) / std::abs(creep.first_v);
  creep.samples = static_cast<int>(held_s.size());
  return creep;
}

}  // namespace

std::vector<HeldFrames> held_frames_of(const Dataset& dataset, std::size_t fewest_frames) {
  std::vector<HeldFrames> holds;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      const std::vector<Sample>& steps = repeats[r].steps;
      for (std::size_t first = 0; first < steps.size();) {
        std::size_t end = first + 1;
        while (end < steps.size() && steps[end].setpoint_psi == steps[first].setpoint_psi) ++end;
        const bool rose = first == 0 || steps[first - 1].setpoint_psi < steps[first].setpoint_psi;
        if (end - first >= fewest_frames && steps[first].setpoint_psi > kHeldAbovePsi && steps[first].held_s > 0.0 &&
            steps[end - 1].time_s > steps[first].time_s)
          holds.push_back({s, r, first, end, rose});
        first = end;
      }
    }
  }
  return holds;
}

std::vector<Creep> creep_of(const Dataset& dataset, const std::vector<int>& taxels) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<Creep> found;
  for (const HeldFrames& hold : held_frames_of(dataset)) {
    const SequenceData& data = dataset.sequences[hold.sequence];
    const Repeat& repeat = data.repeats[hold.repeat];
    std::vector<double> held_s, output_v;
    for (std::size_t i = hold.first; i < hold.end; ++i) {
      held_s.push_back(hold.held_s(repeat, i));  // since the command
      output_v.push_back(mean_of_chosen(std::span<const double>(repeat.volts).subspan(i * width, width),
                                        std::span<const int>(taxels)));
    }
    if (output_v.front() == 0.0) continue;
    found.push_back(line_through(held_s, output_v));
    found.back().run = dataset.run;
    found.back().sequence = data.name;
    found.back().pressure_psi = repeat.steps[hold.first].setpoint_psi;
    found.back().up = hold.rose;
  }
  return found;
}

namespace {

constexpr double kOtherPace = 2.0;  // dwell times that differ by this factor are two

double median_dwell_of(const Repeat& repeat) {
  std::vector<double> held;
  for (const Sample& sample : repeat.steps)
    if (sample.setpoint_psi > kHeldAbovePsi && sample.held_s > 0.0) held.push_back(sample.held_s);
  return median_of(std::move(held));
}

// Change of each step of a loop, whose repeats begin at frame `begin`, against the base repeat: squared, into the
// windows that it lies in.
void add_changes(const FrameErrors& run, std::size_t begin, const SequenceData& loop, std::size_t base,
                 const SensorModel& fit, DwellEffect& effect) {
  const std::size_t width = fit.array().size(), levels = fit.pressure_psi.size(), size = loop.repeats[0].steps.size();
  effect.square_psi.assign(2 * levels * width, kNan);
  for (std::size_t at = 0; at < 2 * levels; ++at) {
    std::vector<std::size_t> steps;
    for (std::size_t i = 0; i < size; ++i) {
      const FrameErrors::Frame& frame = run.frames[begin + base * size + i];
      if (frame.up == (at < levels) &&
          std::abs(frame.setpoint_psi - fit.pressure_psi[at % levels]) <= kHistoryWindowPsi + kSameLevelPsi)
        steps.push_back(i);
    }
    for (std::size_t r = 0; r < loop.repeats.size(); ++r)
      for (std::size_t taxel = 0; taxel < width && r != base && !steps.empty(); ++taxel) {
        double squares = 0.0;
        for (const std::size_t i : steps)
          squares += std::pow(run.error_psi[(begin + r * size + i) * width + taxel] -
                                  run.error_psi[(begin + base * size + i) * width + taxel],
                              2);
        double& largest = effect.square_psi[at * width + taxel];
        largest = std::fmax(largest, squares / static_cast<double>(steps.size()));
      }
  }
}

}  // namespace

double median_dwell_s(const Dataset& dataset) {
  std::vector<double> medians;
  for (const SequenceData& sequence : dataset.sequences)
    for (const Repeat& repeat : sequence.repeats) medians.push_back(median_dwell_of(repeat));
  return median_of(std::move(medians));
}

DwellEffect dwell_effect_of(const Dataset& calibration, std::span<const Dataset* const> runs, const SensorModel& fit,
                            int threads) {
  DwellEffect effect;
  const double usual = median_dwell_s(calibration);
  for (const Dataset* run : runs) {
    for (std::size_t s = 0; s < run->sequences.size(); ++s) {
      const SequenceData& loop = run->sequences[s];
      std::vector<double> dwell;
      for (const Repeat& repeat : loop.repeats) dwell.push_back(median_dwell_of(repeat));
      if (dwell.size() < 2 || std::ranges::any_of(dwell, [](double at) { return !(at > 0.0); }) || !(usual > 0.0))
        continue;
      const auto [low, high] = std::ranges::minmax(dwell);
      if (high < kOtherPace * low) continue;
      const auto off = [&](double at) { return std::abs(std::log(at / usual)); };
      const auto base = static_cast<std::size_t>(std::ranges::min_element(dwell, {}, off) - dwell.begin());
      const FrameErrors errors = frame_errors(*run, fit, threads);
      const auto begin = std::ranges::find(errors.frames, s, &FrameErrors::Frame::sequence) - errors.frames.begin();
      effect.run = run->run;
      effect.low_s = low;
      effect.high_s = high;
      add_changes(errors, static_cast<std::size_t>(begin), loop, base, fit, effect);
      effect.not_assessed.clear();
      return effect;
    }
  }
  return effect;
}

}  // namespace tactbench::analysis
