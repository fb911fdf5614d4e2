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
    grid.fail(key, fmt::format("'{}' has {:.12g} positions", key, count),
              fmt::format("a larger step: a recipe may have {}", kMostPositions));
  }
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(range[0] + i * range[2]);
  return values;
}

struct GridAxes {
  std::vector<double> x, y;  // positions
};

KeyTable grid_keys(GridAxes& axes) {
  const auto axis = [](const char* name, std::vector<double>& positions, const char* meaning) {
    return key::made({name, "list of numbers", "mm", "[from, to, step], step above 0", "required", meaning},
                     [name, &positions](const TomlTable& grid) { positions = grid_axis(grid, name); });
  };
  return {axis("x", axes.x, "Places along x"), axis("y", axes.y, "Places along y")};
}

// Row by row, every other row backward, so that the stage never travels a whole row without pressing.
void read_grid(const TomlTable& press, PressPlan& plan) {
  const TomlTable grid = press.table("grid");
  GridAxes axes;
  read_whole(grid, grid_keys(axes));
  const auto& [xs, ys] = axes;
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

void check_forces(const TomlTable& table, const PressPlan& plan) {
  for (std::size_t i = 0; i < plan.forces_n.size(); ++i) {
    const double last = i == 0 ? plan.contact_n : plan.forces_n[i - 1];
    if (plan.forces_n[i] > last) continue;
    table.fail("forces_n", fmt::format("force {} is {:g} N, not above {:g} N", i + 1, plan.forces_n[i], last),
               "forces rise, from above contact_n; the way down is added");
  }
  if (plan.forces_n.empty()) table.fail("forces_n", "'forces_n' is empty", "e.g. [2, 6, 10, 20, 30]");
}

KeyTable force_keys(PressPlan& plan) {
  return {key::required(key::text("object", plan.object,
                                  "Name of the object; stored, and on the simulated rig ring, point or flat")),
          key::number("contact_n", plan.contact_n, {"N"}, {0.01, 10.0},
                      "Force at which the object counts as touching while it approaches"),
          key::numbers("forces_n", plan.forces_n, {"N"},
                       "Forces at which frames are taken, rising, from above contact_n; the way down is added")};
}

KeyTable position_keys(PressPlan& plan) {
  return {key::optional(key::made({"positions_mm", "lists of 2 numbers", "mm", "", "",
                                   "Places [x, y] of the stage, one after another; or [press.grid]"},
                                  [&plan](const TomlTable& press) {
                                    for (const std::vector<double>& at : press.number_lists("positions_mm", 2))
                                      plan.positions_mm.emplace_back(at[0], at[1]);
                                  }))};
}

KeyTable motion_keys(PressPlan& plan) {
  return {key::word("hold", plan.hold_force, {"position", "force"}, "force",
                    "What stands still during the dwell: the position of z, or the force"),
          key::number("approach_mm_per_s", plan.approach_mm_per_s, {"mm/s"}, {kSlowest, 10.0},
                      "Speed of z until it touches"),
          key::number("servo_mm_per_s", plan.servo_mm_per_s, {"mm/s"}, {kSlowest, 10.0},
                      "Speed of z while a force is sought"),
          key::number("clear_mm", plan.clear_mm, {"mm"}, {0.01, 50.0}, "How far z goes back between two places"),
          key::flag("tare", plan.tare, "Whether the force sensor is set to zero before each repeat and after the last"),
          key::flag("registers", plan.registers, "Whether the touches are used to find the taxels under the stage")};
}

KeyTable peak_force_keys(Conditioning& conditioning, const Range& range) {
  return {key::described(key::number("peak_n", conditioning.peak_n, {"N"}, range,
                                     "For kind = \"press\": highest force of such a cycle, from contact_n on"),
                         "the highest of forces_n")};
}

}  // namespace

void add_press_keys(std::vector<KeyFacts>& all) {
  Recipe recipe;
  GridAxes axes;
  for (const KeyTable& keys : {force_keys(recipe.press), position_keys(recipe.press), motion_keys(recipe.press)})
    add_facts(all, "press", keys);
  add_facts(all, "press.grid", grid_keys(axes));
  add_facts(all, "conditioning", peak_force_keys(recipe.conditioning, {0.01, 1000.0}));
}

void read_press(const TomlTable& root, Recipe& recipe) {
  if (!root.has("press")) root.fail("press", "kind = \"press\" without a [press]", "add [press] with forces_n");
  PressPlan& plan = recipe.press;
  read_keys(root, {dwell_key(recipe.dwell_s)});
  for (const double value : recipe.dwell_s) {
    if (value < 0.0 || value > 86400.0) {
      root.fail("dwell_s", fmt::format("'dwell_s' is {:g}, outside 0 to 86400", value), "use 0 to 86400");
    }
  }
  const TomlTable press = root.table("press");
  read_keys(press, force_keys(plan));
  check_forces(press, plan);
  if (press.has("grid") == press.has("positions_mm")) {
    press.fail("positions_mm", "a press recipe needs either positions_mm or [press.grid]",
               "e.g. positions_mm = [[20, 20]]");
  }
  if (press.has("grid")) read_grid(press, plan);
  read_keys(press, position_keys(plan));
  read_whole(press, motion_keys(plan));
  const TomlTable conditioning = root.table("conditioning");
  read_keys(conditioning, {cycles_key(recipe.conditioning)});
  recipe.conditioning.least = recipe.conditioning.cycles;
  recipe.conditioning.peak_n = plan.forces_n.back();
  read_whole(conditioning, peak_force_keys(recipe.conditioning, {plan.contact_n, 1000.0}));
}

}  // namespace tactbench::sequences
