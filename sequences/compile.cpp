#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sequences/recipe.h"
#include "sequences/recipe_parts.h"

namespace tactbench::sequences {

using devices::Psi;

namespace {

// Appends steps one after another; the values that persist from step to step are in `now`.
class PressWriter {
 public:
  PressWriter(std::vector<Step>& steps, const Recipe& recipe, int sequence)
      : steps_(steps), recipe_(recipe), plan_(recipe.press) {
    now_.sequence = sequence;
    now_.hold_force = plan_.hold_force;
  }

  void begin_repeat(int repeat) {
    now_.repeat = repeat;
    now_.ordinal = 0;
    now_.dwell_s = recipe_.dwell_s[static_cast<std::size_t>(repeat) % recipe_.dwell_s.size()];
    place(0);
  }
  void place(std::size_t position) {
    now_.branch = static_cast<int>(2 * position);
    now_.x_mm = plan_.positions_mm[position].first;
    now_.y_mm = plan_.positions_mm[position].second;
  }
  void skip_to_frame(int ordinal) { now_.ordinal = ordinal; }

  void plain(StepKind kind) {
    Step step = now_;
    step.kind = kind;
    if (kind == StepKind::kHome || kind == StepKind::kTare) step.x_mm = step.y_mm = 0.0;
    step.dwell_s = 0.0;
    step.hold_force = false;
    steps_.push_back(step);
  }

  void condition() {
    const Step before = now_;
    now_.branch = -1;
    for (now_.repeat = 0; now_.repeat < recipe_.conditioning.cycles; ++now_.repeat) {
      plain(StepKind::kApproach);
      press(recipe_.conditioning.peak_n, 0.0, recipe_.conditioning.peak_n, false);
      plain(StepKind::kRetract);
    }
    now_ = before;
  }

  void up(bool frames) {
    for (const double force : plan_.forces_n) press(force, 0.0, plan_.forces_n.back(), frames);
  }
  void down() {
    ++now_.branch;
    for (std::size_t i = plan_.forces_n.size() - 1; i-- > 0;) {
      press(plan_.forces_n[i], plan_.forces_n.back(), plan_.forces_n.front(), true);
    }
  }

 private:
  void press(double force, double from, double to, bool frame) {
    Step step = now_;
    step.kind = StepKind::kPress;
    step.force_n = force;
    step.force_from_n = from;
    step.force_to_n = to;
    step.frame = frame;
    steps_.push_back(step);
    if (frame) ++now_.ordinal;
  }

  std::vector<Step>& steps_;
  const Recipe& recipe_;
  const PressPlan& plan_;
  Step now_;
};

// A repeat: tare, then at each position move, approach, up (branch 2 i), down (branch 2 i + 1), retract. A final tare
// shows the drift of the last repeat.
void add_press(std::vector<Step>& steps, const Recipe& recipe, int sequence) {
  PressWriter writer(steps, recipe, sequence);
  for (int repeat = 0; repeat < recipe.repeats; ++repeat) {
    writer.begin_repeat(repeat);
    if (repeat == 0) writer.plain(StepKind::kHome);
    if (recipe.press.tare) writer.plain(StepKind::kTare);
    for (std::size_t position = 0; position < recipe.press.positions_mm.size(); ++position) {
      writer.place(position);
      writer.plain(StepKind::kMoveXy);
      if (repeat == 0) writer.condition();
      writer.plain(StepKind::kApproach);
      writer.up(true);
      writer.down();
      writer.plain(StepKind::kRetract);
    }
  }
  if (recipe.press.tare) writer.plain(StepKind::kTare);
}

std::vector<Step> press_path_to_branch(const Recipe& recipe, int sequence, int repeat, int branch) {
  std::vector<Step> steps;
  PressWriter writer(steps, recipe, sequence);
  const auto position = static_cast<std::size_t>(branch / 2);
  const bool falling = branch % 2 == 1;
  const int frames_up = static_cast<int>(recipe.press.forces_n.size());
  const int frames_a_position = 2 * frames_up - 1;
  writer.begin_repeat(repeat);
  writer.place(position);
  writer.skip_to_frame(branch / 2 * frames_a_position + (falling ? frames_up : 0));
  writer.plain(StepKind::kRetract);
  writer.plain(StepKind::kHome);
  if (recipe.press.tare) writer.plain(StepKind::kTare);
  writer.plain(StepKind::kMoveXy);
  writer.condition();
  writer.plain(StepKind::kApproach);
  if (falling) writer.up(false);
  return steps;
}

double of_repeat(const std::vector<double>& values, int repeat) {
  return values[static_cast<std::size_t>(repeat) % values.size()];
}

void add_cycles(std::vector<Step>& steps, const Recipe& recipe, int sequence, int cycles, Psi peak) {
  Step step;
  step.kind = StepKind::kConditioning;
  step.sequence = sequence;
  step.branch = -1;
  step.dwell_s = recipe.dwell_s.front();
  for (step.repeat = 0; step.repeat < cycles; ++step.repeat) {
    for (const Psi level : {peak, Psi(0.0)}) {
      step.branch_from = level == peak ? Psi(0.0) : peak;
      step.branch_to = step.setpoint = level;
      steps.push_back(step);
    }
  }
}

// The frames of one level: the first on arrival, the others held.
void add_level(std::vector<Step>& steps, const Recipe& recipe, Step& step, bool turn) {
  const double dwell_s = step.dwell_s;
  const bool one = (recipe.frames_at == FramesAt::kTurns && !turn) ||
                   (recipe.frames_at == FramesAt::kHolds && step.setpoint == lowest_of(recipe));
  const int frames = one ? 1 : recipe.frames_per_level;
  for (int frame = 0; frame < frames; ++frame) {
    step.hold = frame > 0;
    if (step.hold) step.dwell_s = recipe.frame_interval_s;
    steps.push_back(step);
    ++step.ordinal;
  }
  step.dwell_s = dwell_s;
}

Step first_of(const Recipe& recipe, int sequence, int repeat) {
  Step step;
  step.sequence = sequence;
  step.repeat = repeat;
  step.dwell_s = of_repeat(recipe.dwell_s, repeat);
  step.ramp_psi_per_s = of_repeat(recipe.ramp_psi_per_s, repeat);
  step.settle = recipe.settle;
  step.setpoint = step.branch_from = recipe.turning_points.front();
  step.branch_to = recipe.turning_points[recipe.turning_points.size() > 1 ? 1 : 0];
  return step;
}

void add_repeat(std::vector<Step>& steps, const Recipe& recipe, int sequence, int repeat) {
  Step step = first_of(recipe, sequence, repeat);
  step.settle = true;  // there is no ramp before the first level
  add_level(steps, recipe, step, true);
  step.settle = recipe.settle;
  for (std::size_t turn = 1; turn < recipe.turning_points.size(); ++turn) {
    const Psi from = recipe.turning_points[turn - 1];
    const Psi to = recipe.turning_points[turn];
    const int count = static_cast<int>(levels_between(recipe, from, to));
    step.branch = static_cast<int>(turn) - 1;
    step.branch_from = from;
    step.branch_to = to;
    for (int i = 1; i <= count; ++i) {
      const double level = (from + (to - from) * (static_cast<double>(i) / count)).value() / recipe.psi_per_unit;
      step.setpoint = i == count ? to : Psi(exact_decimal(level) * recipe.psi_per_unit);
      add_level(steps, recipe, step, i == count);
    }
  }
}

std::vector<Step> levels_path_to_branch(const Recipe& recipe, int sequence, int repeat, int branch) {
  std::vector<Step> steps;
  const Conditioning& conditioning = recipe.conditioning;
  const Psi highest = *std::max_element(recipe.turning_points.begin(), recipe.turning_points.end());
  const bool own = conditioning.cycles > 0;
  add_cycles(steps, recipe, sequence, own ? conditioning.cycles : 1, own ? conditioning.peak : highest);
  Step step = first_of(recipe, sequence, repeat);
  step.kind = StepKind::kConditioning;
  step.settle = true;
  // Branch 0 measures its starting level itself; any other starts from a turning point that is travelled to here.
  for (int turn = 0; turn <= branch && branch > 0; ++turn) {
    const auto at = static_cast<std::size_t>(turn);
    step.branch = std::max(0, turn - 1);
    step.branch_from = recipe.turning_points[turn == 0 ? 0 : at - 1];
    step.branch_to = step.setpoint = recipe.turning_points[at];
    steps.push_back(step);
  }
  return steps;
}

void add_recipe(std::vector<Step>& steps, const Recipe& recipe, int sequence) {
  if (!recipe.prompt_before.empty()) {
    Step prompt;
    prompt.kind = StepKind::kPrompt;
    prompt.sequence = sequence;
    prompt.text = recipe.prompt_before;
    steps.push_back(prompt);
  }
  if (recipe.kind == RecipeKind::kPress) return add_press(steps, recipe, sequence);
  add_cycles(steps, recipe, sequence, recipe.conditioning.cycles, recipe.conditioning.peak);
  for (int repeat = 0; repeat < recipe.repeats; ++repeat) add_repeat(steps, recipe, sequence, repeat);
}

}  // namespace

std::vector<Step> compile(const Recipe& recipe, int sequence) {
  std::vector<Step> steps;
  steps.reserve(static_cast<std::size_t>(step_count(recipe)));
  add_recipe(steps, recipe, sequence);
  return steps;
}

std::vector<Step> compile(const std::vector<Recipe>& recipes) {
  double count = 0.0;
  std::string names;
  for (const Recipe& recipe : recipes) {
    count += step_count(recipe);
    names += (names.empty() ? "" : ", ") + recipe.name;
  }
  if (count > kMaxSteps) {
    throw FileError("TB-FILE-VALUE", fmt::format("the recipes together have {:.12g} steps", count), "recipes " + names,
                    fmt::format("a run may have {:.12g} steps: use several runs", kMaxSteps));
  }
  std::vector<Step> steps;
  steps.reserve(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < recipes.size(); ++i) add_recipe(steps, recipes[i], static_cast<int>(i));
  return steps;
}

std::vector<Step> path_to_branch(const Recipe& recipe, int sequence, int repeat, int branch) {
  if (recipe.kind == RecipeKind::kPress) return press_path_to_branch(recipe, sequence, repeat, branch);
  return levels_path_to_branch(recipe, sequence, repeat, branch);
}

}  // namespace tactbench::sequences
