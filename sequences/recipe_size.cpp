// The size of a recipe by arithmetic alone, before a list of its steps is made.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sequences/recipe_parts.h"

namespace tactbench::sequences {

namespace {

constexpr double kMostSeconds = 366.0 * 86400.0;  // a clock of nanoseconds in 64 bits holds 292 years

double levels_of(const Recipe& recipe) {
  double levels = 1.0;
  for (std::size_t turn = 1; turn < recipe.turning_points.size(); ++turn)
    levels += levels_on_the_way(recipe, recipe.turning_points[turn - 1], recipe.turning_points[turn]);
  return levels;
}

double held_levels_of(const Recipe& recipe) {
  const auto turns = static_cast<double>(recipe.turning_points.size());
  if (recipe.frames_at == FramesAt::kLevels) return levels_of(recipe);
  if (recipe.frames_at == FramesAt::kTurns) return turns;
  return turns - static_cast<double>(std::ranges::count(recipe.turning_points, lowest_of(recipe)));
}

double level_frames_of(const Recipe& recipe) {
  return levels_of(recipe) + (recipe.frames_per_level - 1.0) * held_levels_of(recipe);
}

double forces_of(const Recipe& recipe) { return 2.0 * static_cast<double>(recipe.press.forces_n.size()) - 1.0; }
double positions_of(const Recipe& recipe) { return static_cast<double>(recipe.press.positions_mm.size()); }

double press_steps(const Recipe& recipe) {
  const double positions = positions_of(recipe), tares = recipe.press.tare ? 1.0 : 0.0;
  const double moved = 3.0 + forces_of(recipe);  // to the position, down to contact, the forces, back
  return 1.0 + recipe.repeats * (tares + positions * moved) + positions * 3.0 * recipe.conditioning.cycles + tares;
}

double dwelt_s(const Recipe& recipe) {
  const bool press = recipe.kind == RecipeKind::kPress;
  const double stops = press ? positions_of(recipe) * forces_of(recipe) : levels_of(recipe);
  double sum = recipe.conditioning.cycles * (press ? positions_of(recipe) : 2.0) * recipe.dwell_s.front();
  const double held_s = press ? 0.0 : (level_frames_of(recipe) - stops) * recipe.frame_interval_s;
  for (int repeat = 0; repeat < recipe.repeats; ++repeat)
    sum += stops * recipe.dwell_s[static_cast<std::size_t>(repeat) % recipe.dwell_s.size()] + held_s;
  return sum;
}

// Refuses the key whose number contributes most.
void refuse_steps(const TomlTable& root, const Recipe& recipe, double steps) {
  const bool press = recipe.kind == RecipeKind::kPress;
  const double stops = press ? positions_of(recipe) : levels_of(recipe);
  const double frames = press ? forces_of(recipe) : recipe.frames_per_level;
  const std::string message =
      press ? fmt::format("the recipe has {:.12g} steps ({:.12g} positions, {:.12g} forces up and down, {} repeats)",
                          steps, stops, frames, recipe.repeats)
            : fmt::format("the recipe has {:.12g} steps ({:.12g} levels a repeat, {} frames a level, {} repeats)",
                          steps, stops, recipe.frames_per_level, recipe.repeats);
  const std::string remedy =
      fmt::format("a run may have {:.12g} steps: {}", kMostSteps,
                  press ? "fewer positions, forces or repeats" : "a larger step, or fewer frames a level or repeats");
  if (recipe.repeats > stops && recipe.repeats > frames) root.fail("repeats", message, remedy);
  if (!press) root.fail(frames > stops ? "frames_per_level" : "step", message, remedy);
  const TomlTable table = root.table("press");
  table.fail(frames > stops ? "forces_n" : table.has("grid") ? "grid" : "positions_mm", message, remedy);
}

}  // namespace

double levels_on_the_way(const Recipe& recipe, devices::Psi from, devices::Psi to) {
  return recipe.frames_at == FramesAt::kHolds ? 1.0 : std::round(std::abs((to - from) / recipe.step));
}

devices::Psi lowest_of(const Recipe& recipe) { return std::ranges::min(recipe.turning_points); }

double step_count(const Recipe& recipe) {
  const double prompt = recipe.prompt_before.empty() ? 0.0 : 1.0;
  if (recipe.kind == RecipeKind::kPress) return prompt + press_steps(recipe);
  return prompt + 2.0 * recipe.conditioning.cycles + recipe.repeats * level_frames_of(recipe);
}

void check_size(const TomlTable& root, const Recipe& recipe) {
  if (const double steps = step_count(recipe); !(steps <= kMostSteps)) refuse_steps(root, recipe, steps);
  const double seconds = dwelt_s(recipe);
  if (seconds <= kMostSeconds) return;
  const bool held = (recipe.frames_per_level - 1.0) * recipe.frame_interval_s > recipe.dwell_s.front();
  root.fail(held ? "frame_interval_s" : "dwell_s",
            fmt::format("the recipe dwells for {:.12g} days in {:.12g} steps", seconds / 86400.0, step_count(recipe)),
            fmt::format("a recipe may dwell for {:.12g} days", kMostSeconds / 86400.0));
}

}  // namespace tactbench::sequences
