#include <fmt/format.h>

#include <cmath>

#include "sequences/recipe.h"

namespace tactbench::sequences {

namespace {

double psi_per_unit(const std::string& unit) {
  if (unit == "kPa") return 1.0 / devices::kKilopascalsPerPsi;
  if (unit == "bar") return devices::kPsiPerBar;
  return 1.0;
}

}  // namespace

Recipe parse_recipe(const TomlDocument& document) {
  const TomlTable root = document.root();
  Recipe recipe;
  recipe.text = document.text();
  (void)root.integer("schema", 1, 1);
  recipe.name = root.text("name");
  if (recipe.name.empty()) root.fail("name", "'name' is empty", "give the recipe a short name");
  recipe.title = root.text("title", recipe.name);
  const double unit = psi_per_unit(root.word("unit", {"psi", "kPa", "bar"}));
  recipe.step = devices::Psi(root.number("step") * unit);
  if (recipe.step.value() <= 0.0) root.fail("step", "'step' must be above 0", "use the distance between levels");
  const std::vector<double> points = root.numbers("turning_points");
  if (points.size() < 2) root.fail("turning_points", "fewer than two turning points", "e.g. [0, 60, 0]");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < 0.0) {
      root.fail("turning_points", fmt::format("turning point {} is negative: {:g}", i + 1, points[i]),
                "gauge pressure starts at 0");
    }
    if (i > 0) {
      const double steps = std::abs(points[i] - points[i - 1]) * unit / recipe.step.value();
      if (steps < 0.5 || std::abs(steps - std::round(steps)) > 1e-6) {
        root.fail("turning_points",
                  fmt::format("{:g} to {:g} is not a whole number of steps of {:g}", points[i - 1], points[i],
                              recipe.step.value() / unit),
                  "choose turning points that are whole steps apart");
      }
    }
    recipe.turning_points.emplace_back(points[i] * unit);
  }
  recipe.dwell_s = root.number_in("dwell_s", 2.0, 0.0, 3600.0);
  recipe.repeats = static_cast<int>(root.integer("repeats", 1, 1, 1000));
  const TomlTable conditioning = root.table("conditioning");
  recipe.conditioning_cycles = static_cast<int>(conditioning.integer("cycles", 0, 0, 100));
  const double peak = recipe.conditioning_cycles > 0 ? conditioning.number("peak") : conditioning.number("peak", 0.0);
  recipe.conditioning_peak = devices::Psi(peak * unit);
  conditioning.finish();
  root.finish();
  return recipe;
}

Recipe read_recipe(const std::string& path, const std::vector<Override>& overrides) {
  TomlDocument document = TomlDocument::from_file(path);
  for (const Override& override_value : overrides) document.set(override_value);
  return parse_recipe(document);
}

}  // namespace tactbench::sequences
