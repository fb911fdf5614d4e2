// A recipe made from the part of its text that a test needs.
#pragma once

#include <string>

#include "sequences/recipe.h"

namespace tactbench::sequences {

inline Recipe recipe_of(const std::string& body) {
  return parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\n" + body, "test.toml"));
}

}  // namespace tactbench::sequences
