#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "sequences/pressure_text.h"
#include "sequences/recipe_parts.h"

namespace tactbench::sequences {

namespace {

constexpr double kSlowestRamp = 0.01;  // psi/s: 60 psi in 100 minutes

bool on_grid(double distance, double step) {
  const double steps = std::abs(distance) / step;
  return std::abs(steps - std::round(steps)) <= 1e-6;
}

// 0, high, 0, then `count` random points that alternately rise and fall, then 0. On the grid; drawn with the raw
// generator, because the distributions differ between standard libraries.
std::vector<long> draw(std::uint64_t seed, int count, long low, long high) {
  std::mt19937_64 generator(seed);
  const auto between = [&](long from, long to) {
    return from + static_cast<long>(generator() % static_cast<std::uint64_t>(to - from + 1));
  };
  std::vector<long> points = {0, high, 0};
  for (int i = 0; i < count; ++i) {
    const long last = points.back();
    points.push_back(i % 2 == 0 ? between(std::max(last, low) + 1, high) : between(low, last - 1));
  }
  points.push_back(0);
  return points;
}

std::vector<double> random_points(const TomlTable& root, double step) {
  const TomlTable table = root.table("random");
  const long seed = table.integer("seed", 0, 2'000'000'000);
  const long count = table.integer("reversals", 1, 10'000);
  const double low = table.number("low");
  const double high = table.number("high");
  table.finish();
  if (count % 2 == 0) {
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
  if (high / step > kMostSteps) {
    table.fail("high", fmt::format("{:g} is {:.0f} steps of {:g}", high, high / step, step),
               fmt::format("a larger step: a run may have {:.0f} steps", kMostSteps));
  }
  std::vector<double> points;
  for (const long point : draw(static_cast<std::uint64_t>(seed), static_cast<int>(count), std::lround(low / step),
                               std::lround(high / step))) {
    points.push_back(static_cast<double>(point) * step);
  }
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

void read_pace(const TomlTable& root, Recipe& recipe) {
  recipe.settle = root.word("settle", "band", {"band", "none"}) == "band";
  recipe.dwell_s = root.numbers_or_one("dwell_s", recipe.settle ? 2.0 : 0.0);
  recipe.ramp_psi_per_s = root.numbers_or_one("ramp_psi_per_s", 0.0);
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
  recipe.frames_per_level = static_cast<int>(root.integer("frames_per_level", 1, 1, 100'000));
  recipe.frame_interval_s = root.number_in("frame_interval_s", 1.0, 0.0, 86400.0);
  if (!recipe.settle && recipe.frames_per_level > 1) {
    root.fail("frames_per_level", "several frames at a level that is only passed", "remove settle = \"none\"");
  }
}

void read_conditioning(const TomlTable& root, Recipe& recipe, double unit) {
  const TomlTable table = root.table("conditioning");
  Conditioning& conditioning = recipe.conditioning;
  conditioning.cycles = static_cast<int>(table.integer("cycles", 0, 0, 100));
  conditioning.least = static_cast<int>(table.integer("least", std::min(1, conditioning.cycles), 0, 100));
  // `--set recipe.conditioning.cycles=0` turns it off regardless of the rest of the file.
  if (conditioning.cycles == 0) conditioning.least = 0;
  if (conditioning.least > conditioning.cycles) {
    table.fail("least", fmt::format("at least {} cycles, at most {}", conditioning.least, conditioning.cycles),
               "'cycles' is the greatest number");
  }
  conditioning.change_percent = table.number_in("change_percent", 0.0, 0.0, 100.0);
  const double peak = conditioning.cycles > 0 ? table.number("peak") : table.number("peak", 0.0);
  if (peak < 0.0 || (conditioning.cycles > 0 && peak == 0.0)) {
    table.fail("peak", fmt::format("'peak' is {:g}", peak), "a cycle goes from 0 to a peak above 0");
  }
  conditioning.peak = devices::Psi(peak * unit);
  table.finish();
}

}  // namespace

void read_levels(const TomlTable& root, Recipe& recipe) {
  const double unit = psi_per_unit(root.word("unit", {"psi", "kPa", "bar"}));
  const double step = root.number("step");
  recipe.step = devices::Psi(step * unit);
  if (step <= 0.0) root.fail("step", "'step' must be above 0", "use the distance between levels");
  read_pace(root, recipe);
  if (root.has("random") && root.has("turning_points")) {
    root.fail("random", "both turning_points and [random]", "keep one of the two");
  }
  const std::vector<double> points = root.has("random") ? random_points(root, step) : root.numbers("turning_points");
  check_points(root, points, step, recipe.frames_per_level > 1);
  for (const double point : points) recipe.turning_points.emplace_back(point * unit);
  read_conditioning(root, recipe, unit);
  const TomlTable limits = root.table("limits");
  recipe.limits.least_response_v = limits.number_in("least_response_v", 0.0, 0.0, 100.0);
  recipe.limits.most_dead_taxels = static_cast<int>(limits.integer("most_dead_taxels", -1, -1, 1'000'000));
  limits.finish();
}

}  // namespace tactbench::sequences
