#include "sequences/estimate.h"

#include <algorithm>
#include <cmath>

namespace tactbench::sequences {

namespace {

constexpr double kShortSettling = 0.7, kLongSettling = 2.0;

// The state that one recipe's steps leave for the next one.
struct Standing {
  int sequence = -1;
  double psi = 0.0, force_n = 0.0;
};

double ramp_s(const Step& step, double from_psi, const TimeModel& model) {
  const double way = step.setpoint.value() - from_psi;
  const double own = way > 0.0 ? model.rise_psi_per_s : model.fall_psi_per_s;
  const double rate = step.ramp_psi_per_s > 0.0 ? std::min(step.ramp_psi_per_s, own) : own;
  return std::abs(way) / rate;
}

StepTime chamber_time(const Step& step, Standing& standing, const TimeModel& model) {
  if (step.hold) return {step.dwell_s, step.dwell_s, step.dwell_s};
  const double fixed = step.dwell_s + ramp_s(step, standing.psi, model);
  standing.psi = step.setpoint.value();
  const double settle = step.settle ? model.settle_s : 0.0;
  return {fixed + kShortSettling * settle, fixed + settle, fixed + kLongSettling * settle};
}

StepTime press_time(const Step& step, const PressPlan& plan, Standing& standing, const TimeModel& model) {
  // The stiffness of the contact is not known before the first touch: twice and half of the model's.
  const double servo = std::abs(step.force_n - standing.force_n) / (model.stiffness_n_per_mm * plan.servo_mm_per_s);
  standing.force_n = step.force_n;
  return {step.dwell_s + 0.5 * servo, step.dwell_s + servo, step.dwell_s + 2.0 * servo};
}

StepTime about(double seconds) { return {0.5 * seconds, seconds, 2.0 * seconds}; }

StepTime time_of(const Step& step, const Recipe& recipe, Standing& standing, const TimeModel& model) {
  switch (step.kind) {
    case StepKind::kConditioning:
    case StepKind::kMeasure:
      return chamber_time(step, standing, model);
    case StepKind::kPress:
      return press_time(step, recipe.press, standing, model);
    case StepKind::kApproach:
      standing.force_n = recipe.press.contact_n;
      return about(recipe.press.clear_mm / recipe.press.approach_mm_per_s);
    case StepKind::kRetract:
      return about(recipe.press.clear_mm / recipe.press.approach_mm_per_s);
    case StepKind::kPrompt:
      return about(model.prompt_s);
    case StepKind::kHome:
      return about(model.home_s);
    case StepKind::kTare:
      return about(model.tare_s);
    case StepKind::kMoveXy:
      return about(model.move_s);
  }
  return {};
}

}  // namespace

std::vector<StepTime> step_times(const std::vector<Recipe>& recipes, const std::vector<Step>& steps,
                                 const TimeModel& model) {
  std::vector<StepTime> times;
  times.reserve(steps.size());
  Standing standing;
  for (const Step& step : steps) {
    const Recipe& recipe = recipes.at(static_cast<std::size_t>(step.sequence));
    StepTime time = time_of(step, recipe, standing, model);
    const Conditioning& conditioning = recipe.conditioning;
    if (step.branch < 0 && conditioning.change_percent > 0.0 && step.repeat >= conditioning.least) time.low_s = 0.0;
    if (has_frame(step)) {
      time.low_s += model.frame_s;
      time.likely_s += model.frame_s;
      time.high_s += model.frame_s;
    }
    if (step.sequence != standing.sequence) {
      standing.sequence = step.sequence;
      time.likely_s += 0.5 * recipe.warm_up.at_most_s;
      time.high_s += recipe.warm_up.at_most_s;
    }
    times.push_back(time);
  }
  return times;
}

Estimate estimate(const std::vector<Recipe>& recipes, const std::vector<Step>& steps, const TimeModel& model,
                  double frame_bytes) {
  Estimate result;
  result.steps = static_cast<int>(steps.size());
  for (const StepTime& time : step_times(recipes, steps, model)) {
    result.time.low_s += time.low_s;
    result.time.likely_s += time.likely_s;
    result.time.high_s += time.high_s;
  }
  for (const Step& step : steps) result.frames += has_frame(step) ? 1 : 0;
  constexpr double kRowBytes = 220.0;  // a frame row besides its blob, indexes included
  result.bytes = result.frames * (frame_bytes + kRowBytes);
  return result;
}

}  // namespace tactbench::sequences
