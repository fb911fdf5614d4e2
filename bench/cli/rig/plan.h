// Recipes as files: the shipped ones, and copies of them.
#pragma once

#include <string>
#include <vector>

#include "sequences/recipe.h"

namespace tactbench::bench {

struct Session;

struct ShippedRecipe {
  sequences::RecipeFile file;
  std::string path;
};
// In the order of their names; shipped files that are not recipes, such as a suite, are left out.
std::vector<ShippedRecipe> shipped_recipes();

// The parts of `plan` that do not plan: list all shipped recipes, one line each; print the file of one recipe; copy it
// to NAME.toml. Throw sequences::FileError, and Error TB-FILE-EXISTS.
void list_recipes(const Session& session);
void print_recipe(const std::string& name, const Session& session);
void copy_recipe(const std::string& name, const std::string& file, const Session& session);

}  // namespace tactbench::bench
