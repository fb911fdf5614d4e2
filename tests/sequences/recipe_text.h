// Builds recipes from the part of their text that a test needs.
#pragma once

#include <string>

#include "sequences/recipe.h"

namespace tactbench::sequences {

// Lines 1 to 5 are those before `press`, which follows in [press]; `root` comes before that.
inline Recipe press_of(const std::string& press, const std::string& root = {}) {
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nkind = \"press\"\n" + root + "[press]\nobject = \"ring\"\n" + press, "p.toml"));
}

inline Recipe recipe_of(const std::string& body) {
  return parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\n" + body, "test.toml"));
}

}  // namespace tactbench::sequences
