#include <fmt/format.h>

#include <cmath>

#include "sequences/recipe_parts.h"

namespace tactbench::sequences {

namespace {

constexpr std::size_t kMostPositions = 10'000;
constexpr double kSlowest = 0.001;  // mm/s: the least speed of the slowest axis

// from, from + step, ... up to `to`.
std::vector<double> grid_axis(const TomlTable& grid, const std::string& key) {
  const std::vector<double> range = grid.numbers(key);
  if (range.size() != 3 || range[2] <= 0.0 || range[1] < range[0]) {
    grid.fail(key, fmt::format("'{}' must be [from, to, step] with a step above 0", key),
              fmt::format("e.g. {} = [10, 20, 2.54]", key));
  }
  const double count = std::floor((range[1] - range[0]) / range[2] + 1e-9) + 1.0;
  if (count > static_cast<double>(kMostPositions)) {
    grid.fail(key, fmt::format("'{}' has {:.0f} positions", key, count),
              fmt::format("a larger step: a recipe may have {}", kMostPositions));
  }
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(range[0] + i * range[2]);
  return values;
}

// Row by row, every other row backward, so that the stage never travels a whole row without pressing.
void read_grid(const TomlTable& press, PressPlan& plan) {
  const TomlTable grid = press.table("grid");
  const std::vector<double> xs = grid_axis(grid, "x");
  const std::vector<double> ys = grid_axis(grid, "y");
  grid.finish();
  if (xs.size() * ys.size() > kMostPositions) {
    press.fail("grid", fmt::format("{} x {} positions", xs.size(), ys.size()),
               fmt::format("a recipe may have {}", kMostPositions));
  }
  for (std::size_t row = 0; row < ys.size(); ++row) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      plan.positions_mm.emplace_back(xs[row % 2 == 0 ? i : xs.size() - 1 - i], ys[row]);
    }
  }
}

void read_forces(const TomlTable& table, PressPlan& plan) {
  plan.forces_n = table.numbers("forces_n");
  for (std::size_t i = 0; i < plan.forces_n.size(); ++i) {
    const double last = i == 0 ? plan.contact_n : plan.forces_n[i - 1];
    if (plan.forces_n[i] > last) continue;
    table.fail("forces_n", fmt::format("force {} is {:g} N, not above {:g} N", i + 1, plan.forces_n[i], last),
               "forces rise, from above contact_n; the way down is added");
  }
  if (plan.forces_n.empty()) table.fail("forces_n", "'forces_n' is empty", "e.g. [2, 6, 10, 20, 30]");
}

}  // namespace

void read_press(const TomlTable& root, Recipe& recipe) {
  if (!root.has("press")) root.fail("press", "kind = \"press\" without a [press]", "add [press] with forces_n");
  PressPlan& plan = recipe.press;
  recipe.dwell_s = root.numbers_or_one("dwell_s", 2.0);
  for (const double value : recipe.dwell_s) {
    if (value < 0.0 || value > 86400.0) {
      root.fail("dwell_s", fmt::format("'dwell_s' is {:g}, outside 0 to 86400", value), "use 0 to 86400");
    }
  }
  const TomlTable press = root.table("press");
  plan.object = press.text("object");
  plan.contact_n = press.number_in("contact_n", 0.2, 0.01, 10.0);
  read_forces(press, plan);
  if (press.has("grid") == press.has("positions_mm")) {
    press.fail("positions_mm", "a press recipe needs either positions_mm or [press.grid]",
               "e.g. positions_mm = [[20, 20]]");
  }
  if (press.has("grid")) {
    read_grid(press, plan);
  } else {
    for (const std::vector<double>& at : press.number_lists("positions_mm", 2)) {
      plan.positions_mm.emplace_back(at[0], at[1]);
    }
  }
  plan.hold_force = press.word("hold", "position", {"position", "force"}) == "force";
  plan.approach_mm_per_s = press.number_in("approach_mm_per_s", plan.approach_mm_per_s, kSlowest, 10.0);
  plan.servo_mm_per_s = press.number_in("servo_mm_per_s", plan.servo_mm_per_s, kSlowest, 10.0);
  plan.clear_mm = press.number_in("clear_mm", plan.clear_mm, 0.01, 50.0);
  plan.tare = press.boolean("tare", true);
  plan.registers = press.boolean("registers", false);
  press.finish();
  const TomlTable conditioning = root.table("conditioning");
  recipe.conditioning.cycles = static_cast<int>(conditioning.integer("cycles", 0, 0, 100));
  recipe.conditioning.least = recipe.conditioning.cycles;
  recipe.conditioning.peak_n = conditioning.number_in("peak_n", plan.forces_n.back(), plan.contact_n, 1000.0);
  conditioning.finish();
}

}  // namespace tactbench::sequences
