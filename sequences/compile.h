// Compiles a press recipe into steps: for each position x (up, down). Used only by compile.cpp.
#pragma once

#include <vector>

#include "sequences/recipe.h"

namespace tactbench::sequences {

// A repeat: tare, then at each position move, approach, up (branch 2 i), down (branch 2 i + 1), retract. A final tare
// shows the drift of the last repeat.
void add_press(std::vector<Step>& steps, const Recipe& recipe, int sequence);
std::vector<Step> press_path_to_branch(const Recipe& recipe, int sequence, int repeat, int branch);

}  // namespace tactbench::sequences
