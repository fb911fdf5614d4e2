// The shipped recipes, for `recipes` and for `plan` without a name.
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

// For `plan` without names: name and title of each.
void list_plannable(const Session& session);

}  // namespace tactbench::bench
