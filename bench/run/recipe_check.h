// Preflight of recipes against a bench, before anything is touched: limits, axes, and whether the bench has the devices
// that they need.
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/figures/limits.h"
#include "bench/config/config.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

struct Margin {  // one axis of what the recipes do, beside its limit
  std::string axis, unit;
  double lowest = 0.0, highest = 0.0;
  double low_limit = 0.0, high_limit = 0.0;  // inclusive
  [[nodiscard]] double margin() const;       // the smaller one; below 0: beyond
  [[nodiscard]] bool within() const;
};

// Of `steps`: pressure, and x, y where they move. An axis that the bench does not have has no margin here.
std::vector<Margin> margins(const std::vector<sequences::Step>& steps, const BenchConfig& bench);

// "pressure source", "stage" and so on, each once, in the order of use.
std::vector<std::string> devices_needed(const std::vector<sequences::Recipe>& recipes);

// A level that limits judge at and no full pair of sweeps of the steps passes: what is judged there is inconclusive.
struct LackingLevel {
  double pressure_psi = 0.0;
  std::vector<double> nearest_psi;  // levels of the steps, the next below and above where there are such
};
std::vector<LackingLevel> lacking_levels(const std::vector<sequences::Step>& steps, const analysis::Limits& limits);

// One of them presses objects on the array: it measures with stage and force sensor.
bool needs_press(const std::vector<sequences::Recipe>& recipes);

// Throws Error with ExitCode::kUsage: TB-RECIPE-LIMIT (names recipe, axis and limit), TB-RECIPE-DEVICES.
void check_recipes(const std::vector<sequences::Recipe>& recipes, const BenchConfig& bench);

}  // namespace tactbench::bench
