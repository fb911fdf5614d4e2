// Readers of the parts of a recipe file, one per part, and what compile.cpp shares with them. The readers throw
// FileError.
#pragma once

#include <vector>

#include "sequences/recipe.h"
#include "sequences/toml/key_table.h"

namespace tactbench::sequences {

// [parameters.NAME]: declares them to the document, applies `overrides` with these names, returns the other overrides.
std::vector<Override> read_parameters(TomlDocument& document, Recipe& recipe, const std::vector<Override>& overrides);

// kind = "levels": unit, turning points or [random], step, ramp, frames of a level, [conditioning], [limits].
void read_levels(const TomlTable& root, Recipe& recipe);
void add_levels_keys(std::vector<KeyFacts>& all);

// Key rows that both kinds of recipe share.
Key dwell_key(std::vector<double>& dwell_s);
Key cycles_key(Conditioning& conditioning);

// Of kind = "levels": levels from one turning point to the next, the last included, and the lowest turning point.
double levels_between(const Recipe& recipe, devices::Psi from, devices::Psi to);
devices::Psi lowest_of(const Recipe& recipe);

// Refuses a recipe with more than kMaxSteps steps, or one that dwells for more than a year.
void check_size(const TomlTable& root, const Recipe& recipe);

// kind = "press": [press], [press.grid], [conditioning] in newtons.
void read_press(const TomlTable& root, Recipe& recipe);
void add_press_keys(std::vector<KeyFacts>& all);

}  // namespace tactbench::sequences
