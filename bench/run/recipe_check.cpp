#include "bench/run/recipe_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "analysis/judgement/mpe.h"
#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/uncertainty/empirical_errors.h"
#include "bench/common/error.h"
#include "bench/guard/witness.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/run/stage_steps.h"

namespace tactbench::bench {

using sequences::Recipe;
using sequences::RecipeKind;

sequences::RecipeFile read_recipe_file(const std::string& name, const std::vector<sequences::Override>& overrides) {
  return sequences::read_recipe_file(find_recipe(name), overrides, find_recipe);
}
std::vector<sequences::Recipe> read_recipes(const std::vector<std::string>& names,
                                            const std::vector<sequences::Override>& overrides) {
  std::vector<sequences::Recipe> recipes;
  for (const std::string& name : names)
    std::ranges::move(read_recipe_file(name, overrides).recipes, std::back_inserter(recipes));
  return recipes;
}

namespace {

// Levels in kPa and bar are converted to psi: 60 psi written in kPa may convert back slightly above 60.
constexpr double kRounding = 1e-9;

Margin axis_margin(const char* name, double lowest, double highest, const devices::AxisOptions& axis) {
  return {name, "mm", lowest, highest, axis.low.value(), axis.high.value()};
}

std::string remedy_of(const Margin& margin) {
  if (margin.unit == "psi")
    return fmt::format("lower turning_points or conditioning.peak; the limit is {}", margin.limited_by);
  if (margin.unit == "N") return "lower forces_n; the limit is [limits] force_n in the bench file";
  return "move positions_mm or [press.grid]; the limits are [stage] low_mm and high_mm";
}

// As far as the guard lets a run go and its regulator and witnesses reach.
Margin pressure_margin(const sequences::Extremes& all, const BenchConfig& bench) {
  const double driven = pressure_kind(bench).highest_psi(bench);
  const auto [limit, key] = std::min(
      {std::pair(bench.limits.command_psi, std::string("[limits] command_psi in the bench file")),
       std::pair(driven, "the regulator's range in the bench file,  " + analysis::both_units(driven)),
       std::pair(reference_range(bench).high_psi, "the end of [reference]'s span in the bench file,  " +
                                                      analysis::both_units(bench.reference.span.high.value()))});
  // No lower limit for gauge pressure: falling to 0 is not dangerous.
  return {"pressure", "psi", all.lowest.value(), all.highest.value(), -1e9, limit, key};
}

void check_limits_of(const Recipe& recipe, const BenchConfig& bench) {
  for (const Margin& margin : margins(sequences::compile(recipe, 0), bench)) {
    if (margin.within()) continue;
    const bool high = margin.highest > margin.high_limit;
    throw Error("TB-RECIPE-LIMIT",
                fmt::format("recipe '{}' goes to {} of {}, beyond the bench's limit of {}", recipe.name,
                            margin.text(high ? margin.highest : margin.lowest), margin.axis,
                            margin.text(high ? margin.high_limit : margin.low_limit)),
                fmt::format("recipe '{}', bench '{}'", recipe.name, bench.id), remedy_of(margin));
  }
}

void check_devices_of(const Recipe& recipe, const BenchConfig& bench) {
  const auto lacking = [&](const std::string& what, const std::string& remedy) {
    throw Error("TB-RECIPE-DEVICES",
                fmt::format("recipe '{}' needs {}, which bench '{}' does not have", recipe.name, what, bench.id),
                bench.file, remedy);
  };
  if (recipe.kind == RecipeKind::kPress && !bench.stage) lacking("a stage", "describe it under [stage]");
  if (recipe.kind == RecipeKind::kPress && !bench.force) lacking("a force sensor", "describe it under [force]");
  for (const sequences::Suspension& item : recipe.suspend) {
    const bool has = std::any_of(bench.environment.begin(), bench.environment.end(),
                                 [&](const EnvironmentSensor& sensor) { return sensor.quantity == item.quantity; });
    if (!has) lacking("a sensor of " + item.quantity, "describe it under [[environment.sensor]]");
  }
}

void check_times_of(const Recipe& recipe, const BenchConfig& bench) {
  const double longest = *std::ranges::max_element(recipe.dwell_s);
  if (recipe.step_timeout_s == 0.0 || recipe.step_timeout_s > longest) return;
  throw Error("TB-RECIPE-LIMIT",
              fmt::format("recipe '{}' lets a step take {:g} s, and waits {:g} s before a frame: no step would end in "
                          "time",
                          recipe.name, recipe.step_timeout_s, longest),
              fmt::format("recipe '{}', bench '{}'", recipe.name, bench.id), "raise timeout.step_s, or lower dwell_s");
}

// The force sensor's calibrated range is known once it is open: StageSteps checks again then.
void check_press_of(const Recipe& recipe, const BenchConfig& bench) {
  if (recipe.kind != RecipeKind::kPress) return;
  std::array<double, 6> any;
  any.fill(std::numeric_limits<double>::infinity());
  const std::vector<std::string> complaints = press_complaints(recipe, bench, any);
  if (complaints.empty()) return;
  throw Error("TB-RECIPE-LIMIT", complaints.front(), fmt::format("recipe '{}', bench '{}'", recipe.name, bench.id),
              "lower forces_n, or slow approach_mm_per_s or servo_mm_per_s down; the limits are [limits] force_n and "
              "clear_z_mm and those of [stage], maximum_speed_mm_per_s among them");
}

}  // namespace

std::string Margin::text(double value) const {
  return unit == "psi" ? analysis::both_units(value, 2) : fmt::format("{:.2f} {}", value, unit);
}

double Margin::margin() const { return std::min(high_limit - highest, lowest - low_limit); }
bool Margin::within() const { return margin() >= -kRounding * std::max(1.0, high_limit); }

std::vector<Margin> margins(const std::vector<sequences::Step>& steps, const BenchConfig& bench) {
  std::vector<Margin> list;
  const sequences::Extremes all = sequences::extremes(steps);
  if (all.pressurizes) {
    list.push_back(pressure_margin(all, bench));
  }
  if (all.moves && bench.stage) {
    list.push_back(axis_margin("x", all.lowest_x_mm, all.highest_x_mm, bench.stage->axis(0)));
    list.push_back(axis_margin("y", all.lowest_y_mm, all.highest_y_mm, bench.stage->axis(1)));
  }
  if (all.presses) list.push_back({"force", "N", 0.0, all.largest_force_n, -1e9, bench.limits.force_n[2]});
  return list;
}

std::vector<std::string> devices_needed(const std::vector<Recipe>& recipes) {
  std::vector<std::string> names;
  const auto need = [&](const char* name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  for (const Recipe& recipe : recipes) {
    if (recipe.kind == RecipeKind::kPress) {
      need("stage");
      need("force sensor");
    } else {
      need("pressure source");
      need("pressure reference");
    }
    need("tactile array");
    for (const sequences::Suspension& item : recipe.suspend) need(item.quantity.c_str());
  }
  return names;
}

std::vector<LackingLevel> lacking_levels(const std::vector<sequences::Step>& steps, const analysis::Limits& limits) {
  // In millionths of a psi, as verdicts look up levels: a level's value may differ by rounding between up and down.
  const auto key = [](double psi) { return std::llround(1e6 * psi); };
  std::set<long long> up, down, both;
  for (const sequences::Step& step : steps) {
    if (step.kind != sequences::StepKind::kMeasure) continue;
    const double level = step.setpoint.value(), from = step.branch_from.value(), to = step.branch_to.value();
    const bool turns = key(level) == key(from) || key(level) == key(to);
    if (turns || to > from) up.insert(key(level));
    if (turns || to < from) down.insert(key(level));
  }
  std::set_intersection(up.begin(), up.end(), down.begin(), down.end(), std::inserter(both, both.end()));
  std::vector<LackingLevel> lacking;
  std::vector<double> judged;
  for (const analysis::Limits::Mismatch& mismatch : limits.mismatch) judged.push_back(mismatch.pressure_psi);
  for (const analysis::Limits::Mpe& mpe : limits.mpe)
    if (mpe.low_psi == mpe.high_psi) judged.push_back(mpe.low_psi);
  for (const double pressure_psi : judged) {
    const auto above = both.lower_bound(key(pressure_psi));
    LackingLevel level{pressure_psi, {}};
    if (above != both.begin()) level.nearest_psi.push_back(1e-6 * static_cast<double>(*std::prev(above)));
    if (above != both.end()) level.nearest_psi.push_back(1e-6 * static_cast<double>(*above));
    const bool met = std::ranges::any_of(level.nearest_psi, [&](double nearest) {
      return std::abs(nearest - pressure_psi) <= analysis::kTypedLevelPsi;
    });
    if (!met) lacking.push_back(std::move(level));
  }
  return lacking;
}

namespace {

// The frames of levels, each sequence with its repeats, as they will be stored.
std::vector<analysis::SequenceData> planned_sequences(const std::vector<sequences::Step>& steps) {
  std::map<int, analysis::SequenceData> planned;
  for (const sequences::Step& step : steps) {
    if (step.kind != sequences::StepKind::kMeasure) continue;
    std::vector<analysis::Repeat>& repeats = planned[step.sequence].repeats;
    repeats.resize(std::max(repeats.size(), static_cast<std::size_t>(step.repeat) + 1));
    std::vector<analysis::Sample>& own = repeats.back().steps;
    const double before_s = step.hold && !own.empty() ? own.back().held_s : 0.0;
    own.push_back({step.setpoint.value(), step.setpoint.value(), 0.0, before_s + step.dwell_s});
  }
  std::vector<analysis::SequenceData> list;
  for (auto& [index, sequence] : planned) list.push_back(std::move(sequence));
  return list;
}

std::string lacking_sentence(const LackingLevel& level, analysis::PressureUnit unit) {
  std::vector<std::string> nearest;
  for (const double psi : level.nearest_psi) nearest.push_back(unit.short_text(psi));
  return fmt::format("{} is not measured both up and down, inconclusive there{}", unit.short_text(level.pressure_psi),
                     nearest.empty() ? "" : fmt::format("; the nearest: {}", fmt::join(nearest, ", ")));
}

}  // namespace

NotJudged not_judged(const std::vector<sequences::Step>& steps, const std::vector<sequences::Step>& fitted,
                     const analysis::Limits& limits, analysis::PressureUnit unit) {
  const std::vector<LackingLevel> lacking = lacking_levels(steps, limits);
  const std::vector<analysis::SequenceData> planned = planned_sequences(steps);
  const auto histories = analysis::planned_histories(planned, planned_sequences(fitted));
  const bool counted = std::ranges::any_of(histories, [](std::size_t n) { return n >= analysis::kLeastHistories; });
  NotJudged out;
  for (const LackingLevel& level : lacking) out.why.push_back(lacking_sentence(level, unit));
  std::size_t open = lacking.size();
  for (const analysis::Limits::Mpe& mpe : limits.mpe) {
    if (mpe.low_psi == mpe.high_psi &&
        std::ranges::find(lacking, mpe.low_psi, &LackingLevel::pressure_psi) != lacking.end())
      continue;
    const bool met = std::ranges::any_of(steps, [&](const sequences::Step& step) {
      return step.kind == sequences::StepKind::kMeasure &&
             step.setpoint.value() >= mpe.low_psi - analysis::kTypedLevelPsi &&
             step.setpoint.value() <= mpe.high_psi + analysis::kTypedLevelPsi;
    });
    if (!met)
      out.why.push_back(fmt::format("no level of [[mpe]] {} is measured", display_text(analysis::scope_of(mpe), unit)));
    if (!met || !counted) ++open;
  }
  if (!limits.mpe.empty() && !counted)
    out.why.emplace_back(
        "each [[mpe]] is inconclusive: U of a reading is not determined unless a kind of history (full sweeps, "
        "reversals, small reversals, held pressures) occurs twice; the recipe verification does that");
  out.nothing = !out.why.empty() && open == limits.mismatch.size() + limits.mpe.size();
  return out;
}

bool needs_press(const std::vector<Recipe>& recipes) {
  return std::any_of(recipes.begin(), recipes.end(),
                     [](const Recipe& recipe) { return recipe.kind == RecipeKind::kPress; });
}

std::vector<std::string> recipe_warnings(const std::vector<Recipe>& recipes, const BenchConfig& bench,
                                         analysis::PressureUnit unit) {
  const double count_psi = pressure_kind(bench).step_psi(bench);
  std::vector<std::string> warnings;
  for (const Recipe& recipe : recipes) {
    if (recipe.kind == RecipeKind::kPress || recipe.turning_points.size() < 2) continue;
    std::string finer;
    if (recipe.step.value() < count_psi)
      finer = fmt::format("one step of the set-point, {}: several levels have the same set-point",
                          fmt::format("{:.3g} {}", unit.of(count_psi), unit.symbol()));
    if (recipe.settle && recipe.step.value() < bench.settling.band_psi)
      finer += fmt::format("{}[settling] band_psi, {}: a level counts as reached when its neighbour is",
                           finer.empty() ? "" : ", and than ", unit.short_text(bench.settling.band_psi));
    if (!finer.empty())
      warnings.push_back(fmt::format("recipe '{}' has steps of {}, finer than {}", recipe.name,
                                     unit.short_text(recipe.step.value()), finer));
    const double fastest = *std::ranges::max_element(recipe.ramp_psi_per_s), rate = bench.limits.rate_psi_per_s;
    if (fastest > rate)
      warnings.push_back(fmt::format(
          "recipe '{}' has ramps of {} per second, but the pressure moves at the {} of [limits] rate_psi_per_s",
          recipe.name, unit.short_text(fastest), unit.short_text(rate)));
  }
  return warnings;
}

void check_recipes(const std::vector<Recipe>& recipes, const BenchConfig& bench) {
  for (const Recipe& recipe : recipes) {
    check_devices_of(recipe, bench);
    check_limits_of(recipe, bench);
    check_times_of(recipe, bench);
    check_press_of(recipe, bench);
  }
}

}  // namespace tactbench::bench
