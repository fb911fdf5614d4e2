#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sequences/pressure_text.h"
#include "sequences/recipe_parts.h"

namespace tactbench::sequences {

namespace {

void read_guard(const TomlTable& root, Recipe& recipe) {
  const TomlTable guard = root.table("guard");
  if (recipe.kind == RecipeKind::kPress) {
    recipe.guard.tolerance_n = guard.number_in("tolerance_n", 0.2, 0.0, 100.0);
  } else {
    recipe.guard.tolerance = devices::Psi(guard.number_in("tolerance_psi", 0.2, 0.0, 100.0));
  }
  recipe.guard.redo = static_cast<int>(guard.integer("redo", 2, 0, 20));
  recipe.guard.fail_when_broken = guard.word("on_broken", "fail", {"fail", "flag"}) == "fail";
  guard.finish();
}

void read_suspensions(const TomlTable& root, Recipe& recipe) {
  for (const TomlTable& table : root.tables("suspend")) {
    Suspension item;
    item.quantity = table.word("quantity", {"supply_bar", "temperature_c"});
    item.below = table.has("trip_below");
    if (item.below == table.has("trip_above")) {
      table.fail("quantity", "a [[suspend]] needs either trip_below or trip_above",
                 "for instance trip_below = 6.0 with resume_above = 6.5");
    }
    item.trip = table.number(item.below ? "trip_below" : "trip_above");
    const char* resume = item.below ? "resume_above" : "resume_below";
    item.resume = table.number(resume);
    if (item.below ? item.resume < item.trip : item.resume > item.trip) {
      table.fail(resume,
                 fmt::format("'{}' is {:g}, on the wrong side of the trip at {:g}", resume, item.resume, item.trip),
                 "a quantity must come back past the trip before the run continues");
    }
    item.hold_s = table.number_in("hold_s", 10.0, 0.0, 86400.0);
    item.timeout_s = table.number_in("timeout_s", 3600.0, 0.0, 7 * 86400.0);
    table.finish();
    recipe.suspend.push_back(item);
  }
}

void read_rules(const TomlTable& root, Recipe& recipe) {
  read_guard(root, recipe);
  read_suspensions(root, recipe);
  const TomlTable warm_up = root.table("warm_up");
  recipe.warm_up.drift_percent_per_min = warm_up.number_in("drift_percent_per_min", 0.1, 1e-6, 100.0);
  recipe.warm_up.at_most_s = warm_up.number_in("at_most_s", 0.0, 0.0, 86400.0);
  warm_up.finish();
  const TomlTable dwell = root.table("dwell");
  recipe.dwell_tolerance_s = dwell.number_in("tolerance_s", 0.25, 0.0, 3600.0);
  dwell.finish();
  const TomlTable retry = root.table("retry");
  recipe.retry.frame = static_cast<int>(retry.integer("frame", 1, 0, 20));
  recipe.retry.branch = static_cast<int>(retry.integer("branch", 0, 0, 20));
  recipe.retry.any_passes = retry.word("verdict", "worst", {"worst", "any"}) == "any";
  retry.finish();
  const TomlTable timeout = root.table("timeout");
  recipe.step_timeout_s = timeout.number_in("step_s", 0.0, 0.0, 86400.0);
  timeout.finish();
  const TomlTable prompt = root.table("prompt");
  recipe.prompt_before = prompt.text("before", "");
  prompt.finish();
  recipe.rest_restart_s = root.number_in("rest_restart_s", 3600.0, 0.0, 1e9);
}

constexpr const char* kTypedPrefix = "recipe.";  // prefix of a recipe's keys on the command line

// Errors in a typed value name the key as typed, not the place where the value is kept.
double value_of(const TomlTable& table, const Parameter& parameter, const std::vector<Override>& overrides,
                const std::string& file) {
  const auto typed = std::find_if(overrides.rbegin(), overrides.rend(),
                                  [&](const Override& item) { return item.key == parameter.name; });
  try {
    return table.number_in("value", parameter.standard, parameter.low, parameter.high);
  } catch (const FileError& error) {
    if (typed == overrides.rend()) throw;
    std::string message = error.what();
    if (message.starts_with("'value'")) message.replace(1, 5, parameter.name);
    throw FileError(error.id(), message,
                    fmt::format("--set {}{}={} (over {})", kTypedPrefix, typed->key, typed->value, file),
                    error.remedy());
  }
}

}  // namespace

std::vector<Override> read_parameters(TomlDocument& document, Recipe& recipe, const std::vector<Override>& overrides) {
  std::vector<Override> others;
  const std::vector<std::string> declared = document.root().table("parameters").keys();
  for (const Override& item : overrides) {
    const bool known = std::find(declared.begin(), declared.end(), item.key) != declared.end();
    if (!known) {
      others.push_back(item);
      continue;
    }
    const std::string unit = document.root().table("parameters").table(item.key).text("unit", "");
    document.set({"parameters." + item.key + ".value", as_number_in(unit, item.value), item.value}, kTypedPrefix);
  }
  const TomlTable tables = document.root().table("parameters");
  for (const std::string& name : declared) {
    const TomlTable table = tables.table(name);
    Parameter parameter;
    parameter.name = name;
    parameter.low = table.number("low");
    parameter.high = table.number("high");
    parameter.standard = table.number("default");
    if (parameter.standard < parameter.low || parameter.standard > parameter.high) {
      table.fail(
          "default",
          fmt::format("'default' is {:g}, outside {:g} to {:g}", parameter.standard, parameter.low, parameter.high),
          "choose low <= default <= high");
    }
    parameter.value = value_of(table, parameter, overrides, document.name());
    parameter.unit = table.text("unit", "");
    parameter.help = table.text("help", "");
    table.finish();
    document.define(name, parameter.value);
    recipe.parameters.push_back(parameter);
  }
  return others;
}

namespace {

// Pressures typed with a unit ("step=20kPa") as numbers in the unit of their key: the recipe's, or psi.
void apply_overrides(TomlDocument& document, const std::vector<Override>& overrides) {
  constexpr std::array kInRecipesUnit = {"step", "conditioning.peak", "random.low", "random.high"};
  for (const bool unit_first : {true, false}) {
    for (const Override& item : overrides) {
      if ((item.key == "unit") != unit_first) continue;
      std::string value = item.value;
      if (item.key.ends_with("_psi")) value = as_number_in("psi", value);
      if (std::ranges::find(kInRecipesUnit, item.key) != kInRecipesUnit.end())
        value = as_number_in(document.root().text("unit", "psi"), value);
      document.set({item.key, value, item.value}, kTypedPrefix);
    }
  }
}

}  // namespace

Recipe parse_recipe(TomlDocument document, const std::vector<Override>& overrides) {
  Recipe recipe;
  recipe.text = document.text();
  const std::vector<Override> others = read_parameters(document, recipe, overrides);
  apply_overrides(document, others);
  const TomlTable root = document.root();
  (void)root.table("parameters");
  (void)root.integer("schema", 1, 1);
  recipe.name = root.name("name");
  recipe.title = root.text("title", recipe.name);
  const bool press = root.word("kind", "levels", {"levels", "press"}) == "press";
  recipe.kind = press ? RecipeKind::kPress : RecipeKind::kLevels;
  if (press) {
    read_press(root, recipe);
  } else {
    read_levels(root, recipe);
  }
  const long shortest = static_cast<long>(std::max(recipe.dwell_s.size(), recipe.ramp_psi_per_s.size()));
  recipe.repeats = static_cast<int>(root.integer("repeats", shortest, 1, 1000));
  if (recipe.repeats < shortest) {
    root.fail("repeats", fmt::format("repeats = {} for a list of {}: not all would be used", recipe.repeats, shortest),
              fmt::format("use at least {}, or shorten the list", shortest));
  }
  read_rules(root, recipe);
  root.finish();
  check_size(root, recipe);
  for (const Parameter& parameter : recipe.parameters) {
    // An override may have replaced the "$name" in the file.
    if (document.uses(parameter.name) || !others.empty()) continue;
    root.table("parameters")
        .fail(parameter.name, fmt::format("nothing uses the parameter '{}'", parameter.name),
              fmt::format("write \"${}\" where its value belongs, or remove it", parameter.name));
  }
  return recipe;
}

Recipe read_recipe(const std::string& path, const std::vector<Override>& overrides) {
  return parse_recipe(TomlDocument::from_file(path), overrides);
}

}  // namespace tactbench::sequences
