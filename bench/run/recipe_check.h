// Resolves recipe names, and checks the recipes against a bench before any device is touched: limits, axes, and the
// devices that they need.
#pragma once

#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/limits.h"
#include "bench/config/config.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

// read_recipe_file(): a file or shipped recipe by name. read_recipes(): all recipes that the names refer to.
sequences::RecipeFile read_recipe_file(const std::string& name, const std::vector<sequences::Override>& overrides = {});
std::vector<sequences::Recipe> read_recipes(const std::vector<std::string>& names,
                                            const std::vector<sequences::Override>& overrides = {});

struct Margin {  // range of one axis in the recipes, and its limits
  std::string axis, unit;
  double lowest = 0.0, highest = 0.0;
  double low_limit = 0.0, high_limit = 0.0;  // inclusive
  std::string limited_by = {};               // the key that sets high_limit; empty: the limit of the axis itself
  [[nodiscard]] std::string text(double value) const;  // with its unit, a pressure with both
  [[nodiscard]] double margin() const;                 // the smaller distance to a limit; below 0: beyond it
  [[nodiscard]] bool within() const;
};

// Margins of `steps`: pressure, and x, y if they move. No margin for an axis that the bench lacks.
std::vector<Margin> margins(const std::vector<sequences::Step>& steps, const BenchConfig& bench);

// "pressure source", "stage" ..., each once, in the order of use.
std::vector<std::string> devices_needed(const std::vector<sequences::Recipe>& recipes);

// A level at which the limits require a verdict but which no full pair of sweeps passes: the verdict there is
// inconclusive.
struct LackingLevel {
  double pressure_psi = 0.0;
  std::vector<double> nearest_psi;  // nearest levels of the steps, below and above, if there are any
};
std::vector<LackingLevel> lacking_levels(const std::vector<sequences::Step>& steps, const analysis::Limits& limits);

// The limits that cannot be judged on a run of these steps with models from a run of `fitted` (none: not known).
struct NotJudged {
  std::vector<std::string> why;  // a sentence for each level or [[mpe]] whose verdict is inconclusive in any case
  bool nothing = false;          // none of the limits can be judged
};
NotJudged not_judged(const std::vector<sequences::Step>& steps, const std::vector<sequences::Step>& fitted,
                     const analysis::Limits& limits, analysis::PressureUnit unit);

// True when a recipe presses objects on the array, which needs stage and force sensor.
bool needs_press(const std::vector<sequences::Recipe>& recipes);

// Differences between what the recipe requests and what a run would do, one sentence each: steps finer than one count
// of the output or than the settling band, and ramps faster than the bench allows.
std::vector<std::string> recipe_warnings(const std::vector<sequences::Recipe>& recipes, const BenchConfig& bench,
                                         analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// Throws Error with ExitCode::kUsage: TB-RECIPE-LIMIT (names recipe, axis and limit), TB-RECIPE-DEVICES.
void check_recipes(const std::vector<sequences::Recipe>& recipes, const BenchConfig& bench);

}  // namespace tactbench::bench
