#include "bench/cli/rig/recipes.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/cli/own_copy.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/run/recipe_check.h"

namespace tactbench::bench {

using nlohmann::ordered_json;
using sequences::Recipe;
using sequences::RecipeFile;

std::vector<ShippedRecipe> shipped_recipes() {
  std::vector<ShippedRecipe> shipped;
  for (const std::string& file : shipped_files("sequences")) {
    const std::string path = fmt::format("{}/sequences/{}", share_folder(), file);
    try {
      shipped.push_back({read_recipe_file(path), path});
    } catch (const sequences::FileError&) {
      continue;  // the folder also holds a suite
    }
  }
  return shipped;
}

namespace {

struct RecipeExtent {
  std::size_t steps = 0, frames = 0;
  std::string highest;  // "60.0 psi", "30.0 N"
};

RecipeExtent extent_of(const std::vector<Recipe>& recipes, analysis::PressureUnit unit) {
  const std::vector<sequences::Step> steps = sequences::compile(recipes);
  RecipeExtent extent{steps.size(), 0, {}};
  for (const sequences::Step& step : steps) extent.frames += takes_frame(step) ? 1 : 0;
  const sequences::Extremes reached = sequences::extremes(steps);
  extent.highest =
      reached.pressurizes ? unit.text(reached.highest.value(), 1) : fmt::format("{:.1f} N", reached.largest_force_n);
  return extent;
}

// "31 turning points drawn, ..."; empty where none of them are drawn.
std::string drawn_of(const RecipeFile& file) {
  std::string drawn;
  for (const Recipe& recipe : file.recipes)
    if (!recipe.drawn.empty()) drawn += (drawn.empty() ? "" : "; ") + recipe.drawn;
  return drawn;
}

ordered_json recipe_json(const RecipeFile& file, const std::string& path) {
  const RecipeExtent extent = extent_of(file.recipes, analysis::PressureUnit::kPsi);
  auto names = ordered_json::array();
  for (const Recipe& recipe : file.recipes) names.push_back(recipe.name);
  return {JSON_FIELDS(file, name, title),
          {"file", path},
          JSON_FIELDS(extent, steps, frames, highest),
          {"repeats", file.recipes.front().repeats},
          {"drawn", drawn_of(file)},
          {"recipes", names}};
}

}  // namespace

void list_recipes(const Session& session) {
  auto json = ordered_json::array();
  analysis::doc::Table table{
      .columns = {{"recipe"}, {"frames", true}, {"highest", true}, {.title = "what it is", .cut = true}}};
  for (const ShippedRecipe& shipped : shipped_recipes()) {
    if (session.json) {
      json.push_back(recipe_json(shipped.file, shipped.path));
      continue;
    }
    const RecipeExtent extent = extent_of(shipped.file.recipes, session.unit());
    table.rows.push_back(
        {{shipped.file.name, std::to_string(extent.frames), extent.highest, one_line(shipped.file.title)}});
  }
  if (session.json) return print_json("plan.recipes", {{"recipes", json}});
  print_table(std::move(table));
  tty::print("tactbench plan NAME shows more; plan NAME --copy MINE begins one of your own\n");
}

void print_recipe(const std::string& name, const Session& session) {
  const std::string path = find_recipe(name);
  const RecipeFile file = read_recipe_file(path);
  if (session.json) {
    ordered_json json = recipe_json(file, path);
    json["text"] = file.text;
    return print_json("plan.recipe", json);
  }
  tty::print("# {}\n{}", path, file.text);
}

void copy_recipe(const std::string& name, const std::string& file, const Session& session) {
  const RecipeFile from = read_recipe_file(name);
  write_own_copy({"plan", "a recipe", from.name, from.text, file}, session);
}

}  // namespace tactbench::bench
