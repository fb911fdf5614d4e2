#include "bench/run/phase_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/pressure_unit.h"

namespace tactbench::bench {

using sequences::Recipe;
using sequences::Step;
using sequences::StepKind;

namespace {

std::string conditioning_text(const Step& step, const Recipe& recipe) {
  const bool by_criterion = recipe.conditioning.change_percent > 0.0;
  // A recipe without conditioning cycles is conditioned once before a branch is repeated.
  const int cycles = std::max(1, recipe.conditioning.cycles);
  return fmt::format("conditioning {} of {}{}", step.repeat + 1, by_criterion ? "at most " : "", cycles);
}

// With a frame: where the run is in its plan.
std::string level_text(const Step& step, const Recipe& recipe, int number, int steps, bool rising) {
  std::string words = fmt::format("{}, step {} of {}", recipe.name, number, steps);
  if (recipe.repeats > 1) words += fmt::format(", repeat {} of {}", step.repeat + 1, recipe.repeats);
  return words + (rising ? ", loading" : ", unloading");
}

}  // namespace

std::string phase_of(const Step& step, const Recipe& recipe, int number, int steps) {
  if (step.branch < 0) return conditioning_text(step, recipe);
  switch (step.kind) {
    case StepKind::kConditioning:
      return "travelling to " + analysis::both_units(step.setpoint.value());
    case StepKind::kMeasure:
      return level_text(step, recipe, number, steps, step.branch_to > step.branch_from);
    case StepKind::kPrompt:
      return "asking: " + step.text;
    case StepKind::kTare:
      return "zeroing the force sensor";
    case StepKind::kHome:
      return "homing the stage";
    case StepKind::kMoveXy:
      return fmt::format("moving to x {:g} mm, y {:g} mm", step.x_mm, step.y_mm);
    case StepKind::kApproach:
      return "approaching the specimen";
    case StepKind::kPress:
      if (!step.frame) return fmt::format("pressing to {:g} N", step.force_n);
      return level_text(step, recipe, number, steps, step.force_to_n >= step.force_from_n);
    case StepKind::kRetract:
      return "retracting the stage";
  }
  return {};
}

}  // namespace tactbench::bench
