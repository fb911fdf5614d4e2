// Splits "--set k=v" of the command line or a scenario into overrides of the bench file and of the recipes.
#pragma once

#include <string>
#include <vector>

#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

// "--set k=v": keys that start with "recipe." go to the recipes (without the prefix), all others to the bench file.
struct SplitOverrides {
  std::vector<sequences::Override> all, bench, recipe;
};
// A key that ends in _psi also accepts a pressure in another unit ("limits.trip_psi=450kPa"). Throws Error TB-USAGE if
// the text is not key=value.
SplitOverrides split_overrides(const std::vector<std::string>& set);

}  // namespace tactbench::bench
