#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sequences/random_points.h"
#include "sequences/recipe_parts.h"
#include "sequences/toml/pressure_text.h"

namespace tactbench::sequences {

namespace {

constexpr double kSlowestRamp = 0.01;  // psi/s: 60 psi in 100 minutes

bool on_grid(double distance, double step) {
  const double steps = std::abs(distance) / step;
  return std::abs(steps - std::round(steps)) <= 1e-6;
}

// In the unit that the file names, and as numbers of it: on the grid of `step`.
struct InFile {
  std::string unit;
  double step = 0.0;
  std::vector<double> turning_points;
  RandomKind kind = RandomKind::kReversals;
  long seed = 0, reversals = 1;
  double low = 0.0, high = 0.0, grid = 0.0, peak = 0.0;
};
constexpr Unit kOfFile{"`unit`"};

KeyTable step_keys(InFile& in) {
  return {key::required(key::word("unit", in.unit, {"psi", "kPa", "bar"}, "Unit of the pressures in this file")),
          key::required(key::number("step", in.step, kOfFile, {},
                                    "Distance of two levels, above 0; a frame is taken at each level between the "
                                    "turning points"))};
}

KeyTable point_keys(InFile& in) {
  return {key::numbers("turning_points", in.turning_points, kOfFile,
                       "Pressures at which the direction changes, from the first to the last; whole steps apart; or "
                       "[random]")};
}

KeyTable random_keys(InFile& in) {
  return {
      key::word("kind", in.kind, random_kind_names(),
                "reversals: a loop to `high`, then points anywhere from `low` to `high`; wander: small reversals of "
                "one to three of its steps, through the whole range; press: presses to heights drawn, one in each of "
                "as many equal parts of the range, in an order that is drawn, "
                "each released to 0"),
      key::required(key::number("seed", in.seed, kOne, {0, 2e9},
                                "Turning points are drawn instead of listed; the same seed gives the same ones")),
      key::required(
          key::number("reversals", in.reversals, kOne, {1, 10'000},
                      "How many points, or heights of presses, are drawn; of points an odd number, so that the "
                      "way back to 0 is a fall")),
      key::required(key::number("low", in.low, kOfFile, {}, "Lowest point that is drawn, but for the releases to 0")),
      key::required(key::number("high", in.high, kOfFile, {}, "Highest point that is drawn")),
      key::described(key::number("step", in.grid, kOfFile, {},
                                 "Grid of the points that are drawn: a whole number of the recipe's `step`, at "
                                 "whose levels between the points frames are taken"),
                     "the recipe's `step`")};
}

std::vector<double> random_points(const TomlTable& root, InFile& in) {
  const TomlTable table = root.table("random");
  in.grid = in.step;
  read_whole(table, random_keys(in));
  const long count = in.reversals;
  const double low = in.low, high = in.high, step = in.grid;
  if (step < in.step || !on_grid(step, in.step)) {
    table.fail("step", fmt::format("'step' is {:g}, not a whole number of the recipe's step of {:g}", step, in.step),
               "leave it out, or choose one that is");
  }
  if (count % 2 == 0 && in.kind != RandomKind::kPress) {
    table.fail("reversals", fmt::format("{} reversals end on a lower point, and the way to 0 continues falling", count),
               "use an odd number");
  }
  for (const char* key : {"low", "high"}) {
    if (!on_grid(key[0] == 'l' ? low : high, step)) {
      table.fail(key, fmt::format("'{}' is not a whole number of steps of {:g}", key, step), "choose one that is");
    }
  }
  if (low < 0.0 || high - low < 1.5 * step) {
    table.fail("high", fmt::format("there is no room for reversals between {:g} and {:g}", low, high),
               "0 <= low, and at least two steps from low to high");
  }
  if (high / step > kMaxSteps) {
    table.fail("high", fmt::format("{:g} is {:.12g} steps of {:g}", high, high / step, step),
               fmt::format("a larger step: a run may have {:.12g} steps", kMaxSteps));
  }
  const RandomPoints drawn{in.kind, static_cast<std::uint64_t>(in.seed), static_cast<int>(count),
                           std::lround(low / step), std::lround(high / step)};
  std::vector<double> points;
  for (const long point : draw_points(drawn)) points.push_back(static_cast<double>(point) * step);
  return points;
}

void check_points(const TomlTable& root, const std::vector<double>& points, double step, bool single) {
  if (points.empty() || (points.size() < 2 && !single)) {
    root.fail("turning_points", "fewer than two turning points",
              "e.g. [0, 60, 0]; a single level needs frames_per_level above 1");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < 0.0) {
      root.fail("turning_points", fmt::format("turning point {} is negative: {:g}", i + 1, points[i]),
                "gauge pressure starts at 0");
    }
    if (i == 0) continue;
    const double distance = points[i] - points[i - 1];
    if (std::abs(distance) < 0.5 * step || !on_grid(distance, step)) {
      root.fail("turning_points",
                fmt::format("{:g} to {:g} is not a whole number of steps of {:g}", points[i - 1], points[i], step),
                "choose turning points that are whole steps apart");
    }
  }
}

KeyTable settle_keys(Recipe& recipe) {
  return {key::word("settle", recipe.settle, {"band", "none"}, "band",
                    "band: a frame waits until the level is reached; none: it is taken as the ramp passes the level")};
}

KeyTable pace_keys(Recipe& recipe) {
  if (!recipe.settle) recipe.dwell_s = {0.0};
  return {dwell_key(recipe.dwell_s),
          key::numbers_or_one("ramp_psi_per_s", recipe.ramp_psi_per_s, {"psi/s"},
                              "How fast the set-point changes; 0: as fast as the bench allows. A list: one for each "
                              "repeat")};
}

KeyTable level_frame_keys(Recipe& recipe) {
  recipe.frame_interval_s = 1.0;
  return {key::number("frames_per_level", recipe.frames_per_level, kOne, {1, 100'000},
                      "Frames at each level; more than one is a hold"),
          key::number("frame_interval_s", recipe.frame_interval_s, {"s"}, {0.0, 86400.0},
                      "Time between two frames of one level"),
          key::word("frames_at", recipe.frames_at, {"levels", "turns", "holds"},
                    "levels: frames_per_level are taken at each level; turns: at the turning points alone, and one at "
                    "each level between them; holds: at the turning points alone, one at the lowest, none between")};
}

void read_pace(const TomlTable& root, Recipe& recipe) {
  read_keys(root, settle_keys(recipe));
  read_keys(root, pace_keys(recipe));
  for (const double value : recipe.dwell_s) {
    if (value >= 0.0 && value <= 86400.0 && (recipe.settle || value == 0.0)) continue;
    root.fail("dwell_s", fmt::format("'dwell_s' is {:g}, outside 0 to {}", value, recipe.settle ? 86400 : 0),
              recipe.settle ? "use 0 to 86400" : "frames taken in passing (settle = \"none\") have no dwell");
  }
  for (const double value : recipe.ramp_psi_per_s) {
    if ((value >= kSlowestRamp && value <= 1000.0) || (recipe.settle && value == 0.0)) continue;
    root.fail("ramp_psi_per_s", fmt::format("'ramp_psi_per_s' is {:g}", value),
              fmt::format("use {:g} to 1000{}", kSlowestRamp,
                          recipe.settle ? ", or 0 for the bench's own limit" : ": settle = \"none\" needs a ramp"));
  }
  read_keys(root, level_frame_keys(recipe));
  if (!recipe.settle && recipe.frames_per_level > 1) {
    root.fail("frames_per_level", "several frames at a level that is only passed", "remove settle = \"none\"");
  }
}

KeyTable cycle_keys(Conditioning& conditioning) {
  conditioning.least = std::min(1, conditioning.cycles);
  return {key::described(
      key::number("least", conditioning.least, kOne, {0, 100}, "At least so many, where change_percent may end them"),
      "`1`, or 0 where cycles is 0")};
}

KeyTable change_keys(Conditioning& conditioning) {
  return {key::number("change_percent", conditioning.change_percent, {"% of full scale"}, {0.0, 100.0},
                      "They end when the loop changes from one to the next by less than this; 0: all are done")};
}

KeyTable peak_keys(InFile& in, bool needed) {
  const Key peak =
      key::number("peak", in.peak, kOfFile, {}, "Highest pressure of such a cycle; needed where cycles is above 0");
  return {needed ? key::required(peak) : peak};
}

void read_conditioning(const TomlTable& root, Recipe& recipe, InFile& in, double unit) {
  const TomlTable table = root.table("conditioning");
  Conditioning& conditioning = recipe.conditioning;
  read_keys(table, {cycles_key(conditioning)});
  read_keys(table, cycle_keys(conditioning));
  // `--set recipe.conditioning.cycles=0` turns it off regardless of the rest of the file.
  if (conditioning.cycles == 0) conditioning.least = 0;
  if (conditioning.least > conditioning.cycles) {
    table.fail("least", fmt::format("at least {} cycles, at most {}", conditioning.least, conditioning.cycles),
               "'cycles' is the greatest number");
  }
  read_keys(table, change_keys(conditioning));
  read_keys(table, peak_keys(in, conditioning.cycles > 0));
  const double peak = in.peak;
  if (peak < 0.0 || (conditioning.cycles > 0 && peak == 0.0)) {
    table.fail("peak", fmt::format("'peak' is {:g}", peak), "a cycle goes from 0 to a peak above 0");
  }
  conditioning.peak = devices::Psi(peak * unit);
  table.finish();
}

KeyTable limit_keys(FailFast& limits) {
  return {key::number("least_response_v", limits.least_response_v, {"V"}, {0.0, 100.0},
                      "A run ends in its first cycle when the mean output at the first peak is not this far above the "
                      "unloaded one; 0: no limit"),
          key::number("most_dead_taxels", limits.most_dead_taxels, kOne, {-1, 1'000'000},
                      "A run ends in its first cycle when more taxels than this do not respond; -1: no limit")};
}

}  // namespace

Key dwell_key(std::vector<double>& dwell_s) {
  return key::numbers_or_one("dwell_s", dwell_s, {"s"},
                             "Time from the level reached to the frame, 0 to 86400; a list: one for each repeat");
}

Key cycles_key(Conditioning& conditioning) {
  return key::number("cycles", conditioning.cycles, kOne, {0, 100},
                     "Cycles without frames before the first repeat, at most; 0: none. First loads differ");
}

void add_levels_keys(std::vector<KeyFacts>& all) {
  Recipe recipe;
  InFile in;
  for (const KeyTable& keys :
       {step_keys(in), settle_keys(recipe), pace_keys(recipe), level_frame_keys(recipe), point_keys(in)})
    add_facts(all, "", keys);
  add_facts(all, "random", random_keys(in));
  for (const KeyTable& keys : {KeyTable{cycles_key(recipe.conditioning)}, cycle_keys(recipe.conditioning),
                               change_keys(recipe.conditioning), peak_keys(in, false)})
    add_facts(all, "conditioning", keys);
  add_facts(all, "limits", limit_keys(recipe.limits));
}

void read_levels(const TomlTable& root, Recipe& recipe) {
  InFile in;
  read_keys(root, step_keys(in));
  const double unit = psi_per_unit(in.unit), step = in.step;
  recipe.step = devices::Psi(step * unit);
  recipe.psi_per_unit = unit;
  if (step <= 0.0) root.fail("step", "'step' must be above 0", "use the distance between levels");
  read_pace(root, recipe);
  if (root.has("random") && root.has("turning_points")) {
    root.fail("random", "both turning_points and [random]", "keep one of the two");
  }
  if (root.has("random")) {
    in.turning_points = random_points(root, in);
    recipe.drawn = fmt::format("{} {} drawn, kind {}, seed {}", in.reversals,
                               in.kind == RandomKind::kPress ? "heights" : "turning points",
                               random_kind_names()[static_cast<std::size_t>(in.kind)], in.seed);
  } else {
    read_keys(root, point_keys(in));
  }
  const std::vector<double>& points = in.turning_points;
  check_points(root, points, step, recipe.frames_per_level > 1);
  for (const double point : points) recipe.turning_points.emplace_back(exact_decimal(point) * unit);
  read_conditioning(root, recipe, in, unit);
  const TomlTable limits = root.table("limits");
  read_whole(limits, limit_keys(recipe.limits));
}

// The size of a recipe by arithmetic alone, before a list of its steps is made.

namespace {

constexpr double kMostSeconds = 366.0 * 86400.0;  // a clock of nanoseconds in 64 bits holds 292 years

double levels_of(const Recipe& recipe) {
  double levels = 1.0;
  for (std::size_t turn = 1; turn < recipe.turning_points.size(); ++turn)
    levels += levels_between(recipe, recipe.turning_points[turn - 1], recipe.turning_points[turn]);
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
      fmt::format("a run may have {:.12g} steps: {}", kMaxSteps,
                  press ? "fewer positions, forces or repeats" : "a larger step, or fewer frames a level or repeats");
  if (recipe.repeats > stops && recipe.repeats > frames) root.fail("repeats", message, remedy);
  if (!press) root.fail(frames > stops ? "frames_per_level" : "step", message, remedy);
  const TomlTable table = root.table("press");
  table.fail(frames > stops ? "forces_n" : table.has("grid") ? "grid" : "positions_mm", message, remedy);
}

}  // namespace

double levels_between(const Recipe& recipe, devices::Psi from, devices::Psi to) {
  return recipe.frames_at == FramesAt::kHolds ? 1.0 : std::round(std::abs((to - from) / recipe.step));
}

devices::Psi lowest_of(const Recipe& recipe) { return std::ranges::min(recipe.turning_points); }

double step_count(const Recipe& recipe) {
  const double prompt = recipe.prompt_before.empty() ? 0.0 : 1.0;
  if (recipe.kind == RecipeKind::kPress) return prompt + press_steps(recipe);
  return prompt + 2.0 * recipe.conditioning.cycles + recipe.repeats * level_frames_of(recipe);
}

void check_size(const TomlTable& root, const Recipe& recipe) {
  if (const double steps = step_count(recipe); !(steps <= kMaxSteps)) refuse_steps(root, recipe, steps);
  const double seconds = dwelt_s(recipe);
  if (seconds <= kMostSeconds) return;
  const bool held = (recipe.frames_per_level - 1.0) * recipe.frame_interval_s > recipe.dwell_s.front();
  root.fail(held ? "frame_interval_s" : "dwell_s",
            fmt::format("the recipe dwells for {:.12g} days in {:.12g} steps", seconds / 86400.0, step_count(recipe)),
            fmt::format("a recipe may dwell for {:.12g} days", kMostSeconds / 86400.0));
}

}  // namespace tactbench::sequences
