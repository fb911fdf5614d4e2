// Describes a step of a run as text, for the progress line, `status` and `watch`.
#pragma once

#include <string>

#include "sequences/recipe.h"

namespace tactbench::bench {

// "conditioning 2 of 6"; "descending, step 19 of 217, repeat 1 of 5, unloading". `number`: of the step, from 1;
// `steps`: in the run.
std::string phase_of(const sequences::Step& step, const sequences::Recipe& recipe, int number, int steps);

}  // namespace tactbench::bench
