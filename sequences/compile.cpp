#include <algorithm>
#include <cmath>

#include "sequences/recipe.h"

namespace tactbench::sequences {

using devices::Psi;

std::vector<Step> compile(const Recipe& recipe, int sequence) {
  std::vector<Step> steps;
  const Psi start = recipe.turning_points.front();
  for (int cycle = 0; cycle < recipe.conditioning_cycles; ++cycle) {
    for (const Psi level : {recipe.conditioning_peak, Psi(0.0)}) {
      Step step;
      step.kind = StepKind::kConditioning;
      step.sequence = sequence;
      step.repeat = cycle;
      step.setpoint = level;
      step.dwell_s = recipe.dwell_s;
      steps.push_back(step);
    }
  }
  for (int repeat = 0; repeat < recipe.repeats; ++repeat) {
    Step step;
    step.sequence = sequence;
    step.repeat = repeat;
    step.dwell_s = recipe.dwell_s;
    step.setpoint = start;
    step.branch_from = start;
    step.branch_to = recipe.turning_points[1];
    steps.push_back(step);
    for (std::size_t turn = 1; turn < recipe.turning_points.size(); ++turn) {
      const Psi from = recipe.turning_points[turn - 1];
      const Psi to = recipe.turning_points[turn];
      const int count = static_cast<int>(std::lround(std::abs((to - from) / recipe.step)));
      step.branch = static_cast<int>(turn) - 1;
      step.branch_from = from;
      step.branch_to = to;
      for (int i = 1; i <= count; ++i) {
        ++step.ordinal;
        // The last level is the turning point itself, not a sum of rounded steps.
        step.setpoint = i == count ? to : from + (to - from) * (static_cast<double>(i) / count);
        steps.push_back(step);
      }
    }
  }
  return steps;
}

std::vector<Step> compile(const std::vector<Recipe>& recipes) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < recipes.size(); ++i) {
    const std::vector<Step> more = compile(recipes[i], static_cast<int>(i));
    steps.insert(steps.end(), more.begin(), more.end());
  }
  return steps;
}

Estimate estimate(const std::vector<Step>& steps, double slew_psi_per_s, double settle_s, double frame_bytes) {
  Estimate result;
  result.steps = static_cast<int>(steps.size());
  Psi last(0.0);
  for (const Step& step : steps) {
    result.seconds += step.dwell_s + settle_s + std::abs((step.setpoint - last).value()) / slew_psi_per_s;
    result.lowest = std::min(result.lowest, step.setpoint);
    result.highest = std::max(result.highest, step.setpoint);
    if (step.kind == StepKind::kMeasure) ++result.frames;
    last = step.setpoint;
  }
  constexpr double kRowBytes = 220.0;  // a frame row besides its blob, indexes included
  result.bytes = result.frames * (frame_bytes + kRowBytes);
  return result;
}

}  // namespace tactbench::sequences
