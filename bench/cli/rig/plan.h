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
// In the order of their names; a shipped file that is no recipe, such as a suite, is left out.
std::vector<ShippedRecipe> shipped_recipes();

// What `plan` prints of recipes without planning: all shipped ones, one line each; one's file; and the file that it
// begins as a copy, NAME.toml. Throw sequences::FileError, and Error TB-FILE-EXISTS.
void list_recipes(const Session& session);
void print_recipe(const std::string& name, const Session& session);
void copy_recipe(const std::string& name, const std::string& file, const Session& session);

}  // namespace tactbench::bench
